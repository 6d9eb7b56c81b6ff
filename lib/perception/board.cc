#include "lib/perception/board.h"

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/check_range.h"

namespace secondlook::perception {
namespace {

constexpr int kMinCorners = 8;
/// Farther from where the others want it, a corner is something else.
constexpr double kMaxCornerError_px = 1.0;

cv::Ptr<cv::aruco::CharucoBoard> Make(const Board& board) {
  board.Validate();
  return cv::aruco::CharucoBoard::create(
      board.columns, board.rows, static_cast<float>(board.square), static_cast<float>(board.marker),
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_100));
}

cv::Matx33d MatrixOf(const geometry::CameraModel& camera) {
  return {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
}

/// Those of `list` that have a mark; all when there are no marks.
template <class T>
void KeepOnly(const std::vector<unsigned char>& marks, std::vector<T>* list) {
  std::size_t i = 0;
  std::erase_if(*list, [&](const T&) { return !marks.empty() && marks[i++] == 0; });
}

Pose PoseOf(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  Pose X_CP = Pose::Identity();
  X_CP.linear() = RotationFromVector({rotation[0], rotation[1], rotation[2]});
  X_CP.translation() = Eigen::Vector3d(translation[0], translation[1], translation[2]);
  return X_CP;
}

}  // namespace

void Board::Validate() const {
  CheckRange(columns, 3, 14, "'columns'");
  CheckRange(rows, 3, 14, "'rows'");
  CheckRange(square, 0.005, 1.0, "'square'");
  CheckRange(marker, 0.3 * square, 0.95 * square, "'marker'");
}

std::optional<SeenBoard> FindBoard(const cv::Mat& color, const geometry::CameraModel& camera,
                                   const Board& board) {
  const cv::Ptr<cv::aruco::CharucoBoard> charuco = Make(board);
  const cv::Matx33d matrix = MatrixOf(camera);
  cv::Mat gray;
  cv::cvtColor(color, gray, cv::COLOR_RGB2GRAY);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(gray, charuco->dictionary, markers, marker_ids);
  if (marker_ids.empty()) return std::nullopt;
  std::vector<cv::Point2f> corners;
  std::vector<int> ids;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, gray, charuco, corners, ids, matrix);
  if (std::ssize(ids) < kMinCorners) return std::nullopt;
  // OpenCV 4.6 leaves them half a pixel to the right and below of where they are.
  const cv::TermCriteria done(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-3);
  cv::cornerSubPix(gray, corners, {3, 3}, {-1, -1}, done);
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> points_P;
  for (const int id : ids) {
    points.push_back(charuco->chessboardCorners[static_cast<std::size_t>(id)]);
    points_P.emplace_back(points.back().x, points.back().y);
  }
  // A corner may have been drawn to an edge nearby: on one plane, the others tell.
  std::vector<unsigned char> fits;
  cv::findHomography(points_P, corners, cv::RANSAC, kMaxCornerError_px, fits);
  KeepOnly(fits, &points);
  KeepOnly(fits, &corners);
  if (std::ssize(corners) < kMinCorners) return std::nullopt;
  SeenBoard seen;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    seen.points_P.emplace_back(points[i].x, points[i].y, points[i].z);
    seen.corners.emplace_back(corners[i].x, corners[i].y);
  }
  cv::Vec3d rotation;
  cv::Vec3d translation;
  if (!cv::solvePnP(points, corners, matrix, cv::noArray(), rotation, translation, false,
                    cv::SOLVEPNP_IPPE)) {
    return std::nullopt;
  }
  cv::solvePnPRefineLM(points, corners, matrix, cv::noArray(), rotation, translation);
  seen.X_CP = PoseOf(rotation, translation);
  return seen;
}

cv::Mat DrawBoard(const Board& board, int square_px) {
  cv::Mat picture;
  Make(board)->draw({board.columns * square_px, board.rows * square_px}, picture, 0, 1);
  return picture;
}

}  // namespace secondlook::perception
