#pragma once

#include <deque>
#include <string>

#include "lib/common/pose.h"
#include "lib/common/time.h"

namespace secondlook {

/// Time-stamped poses of one frame in another, asked for at the time of a measurement. Between two
/// samples the translation is linear and the rotation spherical-linear.
class PoseHistory {
 public:
  /// `name` is what errors call it, e.g. "X_WB"; `keep` > 0 is how far back it remembers.
  PoseHistory(std::string name, Duration keep);

  /// Appends a sample. Samples not later than the last one are ignored, as a poll faster than the
  /// device returns the same state twice; a pose that is not rigid throws InvalidArgument.
  void Add(Time time, const Pose& X_AB);

  /// The pose at `time`.
  /// @throws InvalidArgument when there is no sample yet, when `time` lies before the oldest sample
  /// or after the newest: a pose is interpolated, never extrapolated.
  Pose At(Time time) const;

 private:
  struct Sample {
    Time time;
    Pose X_AB;
  };
  std::string name_;
  Duration keep_;
  std::deque<Sample> samples_;
};

}  // namespace secondlook
