#include "lib/common/pose_history.h"

#include <algorithm>
#include <utility>

#include "lib/common/error.h"

namespace secondlook {

PoseHistory::PoseHistory(std::string name, Duration keep) : name_(std::move(name)), keep_(keep) {
  if (keep <= Duration::zero()) {
    Throw<InvalidArgument>("pose history '{}': keep = {} s; it must be positive", name_,
                           ToSeconds(keep));
  }
}

void PoseHistory::Add(Time time, const Pose& X_AB) {
  if (!IsValid(X_AB)) {
    Throw<InvalidArgument>("pose history '{}': the pose at {:.3f} s is not a rigid transform",
                           name_, ToSeconds(time));
  }
  if (!samples_.empty() && time <= samples_.back().time) return;
  samples_.push_back({time, X_AB});
  while (samples_.size() > 2 && samples_[1].time <= time - keep_) samples_.pop_front();
}

Pose PoseHistory::At(Time time) const {
  if (samples_.empty()) Throw<InvalidArgument>("pose history '{}' is empty", name_);
  if (time < samples_.front().time || time > samples_.back().time) {
    Throw<InvalidArgument>(
        "pose history '{}': asked for {:.3f} s, but it covers {:.3f} s to {:.3f} s; poses are not "
        "extrapolated",
        name_, ToSeconds(time), ToSeconds(samples_.front().time), ToSeconds(samples_.back().time));
  }
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), time,
                                      [](const Sample& s, Time t) { return s.time < t; });
  if (after->time == time) return after->X_AB;
  const auto before = std::prev(after);
  const double fraction = ToSeconds(time - before->time) / ToSeconds(after->time - before->time);
  const Eigen::Quaterniond q0(before->X_AB.linear());
  const Eigen::Quaterniond q1(after->X_AB.linear());
  Pose X_AB = Pose::Identity();
  X_AB.linear() = q0.slerp(fraction, q1).toRotationMatrix();
  X_AB.translation() =
      (1.0 - fraction) * before->X_AB.translation() + fraction * after->X_AB.translation();
  return X_AB;
}

}  // namespace secondlook
