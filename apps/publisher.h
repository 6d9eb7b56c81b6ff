#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "apps/capture.h"
#include "apps/occupancy_changes.h"
#include "lib/hal/robot.h"
#include "lib/transport/message.h"
#include "lib/world/look.h"
#include "lib/world/scene_belief.h"
#include "lib/world/task.h"
#include "lib/world/voxel_space.h"

#include "second_look/mission_t.hpp"

namespace secondlook::apps {

/// What the mission is doing, for STATUS.
struct Activity {
  std::string phase{"starting"};  ///< As status_t names it.
  std::string detail;             ///< In words.
  int step{};
  Time time{};  ///< Robot time when it began.
};

/// How long a part of a step took.
struct StageTime {
  std::string name;
  double robot_seconds{};
  double wall_seconds{};
};

/// Tells what the mission sees, believes and does, as the messages of docs/channels.md, to every
/// sink. Nothing it is told changes the mission. Threading: activity() from any thread, the rest
/// from the mission's.
class Publisher {
 public:
  /// `sinks` must outlive this. Without any, nothing is encoded.
  explicit Publisher(std::vector<transport::Sink*> sinks = {});

  /// The mission begins, or has ended.
  void Mission(const second_look::mission_t& mission);

  /// A new turn of the cycle: all that follows belongs to it. Counts from 1.
  void BeginStep() { ++step_; }
  int step() const { return step_; }

  /// The frame as it came.
  void Image(const hal::RgbdFrame& frame);
  /// What was understood of it: the newest view of `belief`, or nothing and `reason` why.
  void View(const Capture& capture, const world::SceneBelief& belief, const std::string& reason);
  /// The support plane and the objects.
  void Belief(const world::SceneBelief& belief, Time time);
  /// What changed in the workspace of the map; nothing when it has none.
  void Map(const world::VoxelSpace& space, Time time);
  void Candidates(const std::vector<world::Look>& looks, Time time);
  /// The look that is taken now, and where it sends the base.
  void Look(const world::Look& look, Time time);
  /// How far the way there is; `phase` as nav_status_t has it.
  void NavStatus(int phase, const std::string& reason, const hal::BaseState& base,
                 const hal::PanTiltAngles& head, double metres);
  void Timing(const std::vector<StageTime>& stages, Time time);

  /// Says what the mission is doing now.
  void Doing(std::string phase, std::string detail, Time time);
  Activity activity() const;

 private:
  bool Silent() const { return sinks_.empty(); }
  template <class T>
  void Post(const char* channel, const T& body);
  template <class T, class Item>
  void PostInPieces(const char* channel, T body, std::vector<Item> T::*list,
                    std::int32_t T::*count);

  std::vector<transport::Sink*> sinks_;
  OccupancyChanges occupancy_;
  int step_{};
  mutable std::mutex mutex_;  // of activity_
  Activity activity_;
};

}  // namespace secondlook::apps
