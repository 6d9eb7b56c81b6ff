#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace secondlook::apps {

/// A named line through its points (x, y).
struct Curve {
  std::string name;
  std::vector<Eigen::Vector2d> points;
};

/// The part of the plane that a plot shows.
struct PlotAxes {
  std::string title;
  std::string x, y;  ///< What they are.
  Eigen::Vector2d low{0.0, 0.0};
  Eigen::Vector2d high{1.0, 1.0};  ///< Beyond `low` in both.
};

/// Draws up to six curves as a PNG. @throws ConfigError when the file cannot be written.
void WritePlot(const PlotAxes& axes, const std::vector<Curve>& curves,
               const std::filesystem::path& path);

}  // namespace secondlook::apps
