#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"

namespace secondlook::perception {

/// A ChArUco board: a chessboard with an ArUco marker (4 x 4 bits) in every white square. Its frame
/// P lies in one of its outer corners, x along its columns, y along its rows.
struct Board {
  int columns{7};       ///< Squares …
  int rows{5};          ///< … in each direction, 3 to 14.
  double square{0.08};  ///< Side of a square [m].
  double marker{0.06};  ///< Side of a marker [m], smaller.

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What is seen of a board.
struct SeenBoard {
  std::vector<Eigen::Vector2d> corners;   ///< Inner corners of the chessboard [px] …
  std::vector<Eigen::Vector3d> points_P;  ///< … and which these are [m].
  Pose X_CP{Pose::Identity()};            ///< Where the board is, by these corners alone.
};

/// Finds `board` in `color` (CV_8UC3, RGB, undistorted); a part of it is enough. Empty when fewer
/// than 8 corners are seen. S. Garrido-Jurado et al., "Automatic generation and detection of highly
/// reliable fiducial markers under occlusion", Pattern Recognition 47, 2014.
std::optional<SeenBoard> FindBoard(const cv::Mat& color, const geometry::CameraModel& camera,
                                   const Board& board);

/// The board as a picture, CV_8UC1, so many pixels to a square, without a margin: to be printed.
cv::Mat DrawBoard(const Board& board, int square_px);

}  // namespace secondlook::perception
