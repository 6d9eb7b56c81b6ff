#include "lib/fusion/cross_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::fusion {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

double EightPointDistance(const Eigen::Vector2d& p, const cv::Rect2d& box) {
  double least = kFar;
  for (const double x : {0.0, 0.5, 1.0}) {
    for (const double y : {0.0, 0.5, 1.0}) {
      if (x == 0.5 && y == 0.5) continue;
      const Eigen::Vector2d q(box.x + x * box.width, box.y + y * box.height);
      least = std::min(least, (p - q).norm());
    }
  }
  return least;
}

double CenterDistance(const Eigen::Vector2d& p, const cv::Rect2d& box) {
  const double dx = (p.x() - box.x) / (0.5 * box.width) - 1.0;
  const double dy = (p.y() - box.y) / (0.5 * box.height) - 1.0;
  return std::hypot(dx, dy) * 0.25 * (box.width + box.height);
}

/// 0 inside the box.
double OutsideBy(const Eigen::Vector2d& p, const cv::Rect2d& box) {
  const double dx = std::max({box.x - p.x(), 0.0, p.x() - box.x - box.width});
  const double dy = std::max({box.y - p.y(), 0.0, p.y() - box.y - box.height});
  return std::hypot(dx, dy);
}

/// For each of `queries` its nearest of `others` by distance(query, other), -1 when all are
/// infinitely far; of several with one nearest, the nearest of them has it and the rest none.
template <class Distance>
std::vector<int> Associate(int queries, int others, const Distance& distance) {
  std::vector<int> partner(queries, -1);
  std::vector<int> taken_by(others, -1);
  for (int q = 0; q < queries; ++q) {
    double least = kFar;
    for (int o = 0; o < others; ++o) {
      if (distance(q, o) >= least) continue;
      least = distance(q, o);
      partner[q] = o;
    }
    if (partner[q] < 0) continue;
    int& holder = taken_by[partner[q]];
    if (holder >= 0 && distance(holder, partner[q]) <= least) {
      partner[q] = -1;
    } else {
      if (holder >= 0) partner[holder] = -1;
      holder = q;
    }
  }
  return partner;
}

/// Whether a match is `deviations` standard deviations farther than the others are on average.
bool IsIrregular(const std::vector<CrossMatch>& matches, std::size_t which, double deviations) {
  if (matches.size() < 3) return false;
  double mean = 0.0;
  double square = 0.0;
  const auto others = static_cast<double>(matches.size() - 1);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (i == which) continue;
    mean += matches[i].distance_px / others;
    square += matches[i].distance_px * matches[i].distance_px / others;
  }
  const double deviation = std::sqrt(std::max(square - mean * mean, 1.0));  // a pixel at least
  return matches[which].distance_px > mean + deviations * deviation;
}

}  // namespace

void CrossMatchConfig::Validate() const {
  CheckRange(max_distance_px, 0.0, 1e5, "max_distance_px");
  CheckRange(max_deviations, 0.0, 1e3, "max_deviations");
  CheckRange(position_sigma_m, 1e-6, 10.0, "position_sigma_m");
  CheckRange(max_sigmas, 0.0, 1e3, "max_sigmas");
}

CrossMatches MatchAcrossCameras(const std::vector<Eigen::Vector3d>& p_AO,
                                const std::vector<cv::Rect2d>& boxes_B, const Pose& X_BA,
                                const geometry::CameraModel& camera_B,
                                const CrossMatchConfig& config) {
  config.Validate();
  camera_B.Validate("second");
  if (!X_BA.matrix().allFinite()) {
    Throw<InvalidArgument>("the pose between the cameras is not finite; calibrate them");
  }
  const auto objects = static_cast<int>(p_AO.size());
  const auto boxes = static_cast<int>(boxes_B.size());
  std::vector<Eigen::Vector3d> p_BO;
  std::vector<Eigen::Vector2d> pixels;
  for (int i = 0; i < objects; ++i) {
    if (!p_AO[i].allFinite()) {
      Throw<InvalidArgument>("object {}: its centroid is not finite; leave it out", i);
    }
    const Eigen::Vector3d p = X_BA * p_AO[i];
    p_BO.push_back(p);
    pixels.emplace_back(camera_B.cx + camera_B.fx * p.x() / p.z(),
                        camera_B.cy + camera_B.fy * p.y() / p.z());
  }
  for (int i = 0; i < boxes; ++i) {
    if (!(boxes_B[i].width > 0.0 && boxes_B[i].height > 0.0)) {
      Throw<InvalidArgument>("box {} of the second camera is {} x {} pixels", i, boxes_B[i].width,
                             boxes_B[i].height);
    }
  }
  const auto distance = [&](int object, int box) {
    if (!(p_BO[object].z() > 0.0)) return kFar;
    return config.distance == BoxDistance::kCenter
               ? CenterDistance(pixels[object], boxes_B[box])
               : EightPointDistance(pixels[object], boxes_B[box]);
  };
  std::vector<CrossMatch> associated;
  if (objects >= boxes) {
    const std::vector<int> partner = Associate(objects, boxes, distance);
    for (int i = 0; i < objects; ++i) {
      if (partner[i] >= 0) associated.push_back({i, partner[i], distance(i, partner[i])});
    }
  } else {
    const std::vector<int> partner =
        Associate(boxes, objects, [&](int box, int object) { return distance(object, box); });
    for (int i = 0; i < boxes; ++i) {
      if (partner[i] >= 0) associated.push_back({partner[i], i, distance(partner[i], i)});
    }
  }

  CrossMatches result;
  std::vector<std::string> object_reason(objects, "nothing near it in the second camera");
  std::vector<std::string> box_reason(boxes, "nothing near it in the main camera");
  for (int i = 0; i < objects; ++i) {
    if (!(p_BO[i].z() > 0.0)) object_reason[i] = "behind the second camera";
  }
  for (std::size_t i = 0; i < associated.size(); ++i) {
    const CrossMatch& match = associated[i];
    const double focal = 0.5 * (camera_B.fx + camera_B.fy);
    const double outside_m =
        OutsideBy(pixels[match.object], boxes_B[match.box]) * p_BO[match.object].z() / focal;
    std::string reason;
    if (match.distance_px > config.max_distance_px) {
      reason =
          fmt::format("{:.0f} px apart, {:.0f} allowed", match.distance_px, config.max_distance_px);
    } else if (IsIrregular(associated, i, config.max_deviations)) {
      reason = fmt::format("{:.0f} px apart, much farther than all others", match.distance_px);
    } else if (outside_m > config.max_sigmas * config.position_sigma_m) {
      reason = fmt::format("{:.3f} m beside its line of sight, {:.3f} allowed", outside_m,
                           config.max_sigmas * config.position_sigma_m);
    } else {
      result.matches.push_back(match);
    }
    object_reason[match.object] = reason;
    box_reason[match.box] = reason;
  }
  std::sort(result.matches.begin(), result.matches.end(),
            [](const CrossMatch& a, const CrossMatch& b) { return a.object < b.object; });
  for (int i = 0; i < objects; ++i) {
    if (!object_reason[i].empty()) result.unmatched.push_back({true, i, object_reason[i]});
  }
  for (int i = 0; i < boxes; ++i) {
    if (!box_reason[i].empty()) result.unmatched.push_back({false, i, box_reason[i]});
  }
  return result;
}

}  // namespace secondlook::fusion
