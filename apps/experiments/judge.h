#pragma once

#include <limits>
#include <string>
#include <vector>

#include "apps/mission.h"
#include "sim/world.h"

namespace secondlook::apps {

/// When a verified pose counts as right, in the camera frame of the view that verified it.
struct JudgeConfig {
  double max_m = 0.010;
  double max_deg = 5.0;  ///< Up to the object's symmetry in shape and colour.
};

/// What became of one thing that truly stands there, or that was believed to.
struct Verdict {
  enum class Kind {
    kRight,         ///< Known, verified with the right name and pose.
    kMissed,        ///< Known, but not verified: open, or called unknown.
    kWrong,         ///< Verified, but not what and where it says.
    kUnknownRight,  ///< Not in the database, and called unknown.
    kUnknownOpen,   ///< Not in the database, and not settled.
  };
  Kind kind{Kind::kMissed};
  std::string truth;   ///< Its true name; "" when nothing is there.
  bool known{};        ///< The object database holds it.
  std::string belief;  ///< The name it was given; "unknown", or "" when it was left open.
  int object{-1};      ///< Id in the belief; -1: no such object.
  double error_m{std::numeric_limits<double>::quiet_NaN()};    ///< Of the centre; NaN: no pose.
  double error_deg{std::numeric_limits<double>::quiet_NaN()};  ///< Up to symmetry; NaN: no pose.
  /// The same in the frame of the support plane: how far the pose is off in height and in tilt.
  double height_error_m{std::numeric_limits<double>::quiet_NaN()};
  double tilt_error_deg{std::numeric_limits<double>::quiet_NaN()};
};

/// The name of a kind, e.g. "wrong".
const char* ToString(Verdict::Kind kind);

/// Compares what `mission` believes with the truth of `world`: a verdict for every thing that truly
/// stands on the table, then one for each verified object that is none of them or one of them
/// again.
std::vector<Verdict> Judge(const Mission& mission, const sim::World& world,
                           const JudgeConfig& config = {});

}  // namespace secondlook::apps
