#include "apps/publisher.h"

#include <utility>

#include "apps/to_message.h"
#include "lib/transport/channels.h"

#include "second_look/candidates_t.hpp"
#include "second_look/nav_goal_t.hpp"
#include "second_look/nav_status_t.hpp"
#include "second_look/objects_t.hpp"
#include "second_look/occupancy_t.hpp"
#include "second_look/timing_t.hpp"

namespace secondlook::apps {
namespace {

namespace channel = transport::channel;

/// Lists are cut into pieces of so many bytes: several fit into a default socket buffer.
constexpr int kPieceBytes = 48'000;

}  // namespace

Publisher::Publisher(std::vector<transport::Sink*> sinks) : sinks_(std::move(sinks)) {}

template <class T>
void Publisher::Post(const char* channel, const T& body) {
  const transport::Message message = transport::Pack(channel, body);
  for (transport::Sink* sink : sinks_) sink->Post(message);
}

/// Posts `body` with its list cut into pieces; an empty list makes one empty piece.
template <class T, class Item>
void Publisher::PostInPieces(const char* channel, T body, std::vector<Item> T::*list,
                             std::int32_t T::*count) {
  std::vector<std::vector<Item>> pieces(1);
  int bytes = 0;
  for (Item& item : body.*list) {
    const int size = item.getEncodedSize();
    if (!pieces.back().empty() && bytes + size > kPieceBytes) {
      pieces.emplace_back();
      bytes = 0;
    }
    bytes += size;
    pieces.back().push_back(std::move(item));
  }
  body.pieces = static_cast<std::int32_t>(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    body.piece = static_cast<std::int32_t>(i);
    body.*count = static_cast<std::int32_t>(pieces[i].size());
    body.*list = std::move(pieces[i]);
    Post(channel, body);
  }
}

void Publisher::Mission(const second_look::mission_t& mission) {
  if (!Silent()) Post(channel::kMission, mission);
}

void Publisher::Image(const hal::RgbdFrame& frame) {
  if (!Silent()) Post(channel::kImage, ToImages(frame, transport::kMaxMessageBytes));
}

void Publisher::View(const Capture& capture, const world::SceneBelief& belief,
                     const std::string& reason) {
  if (Silent()) return;
  const bool learned = reason.empty();
  const int index = learned ? static_cast<int>(belief.views.size()) - 1 : -1;
  second_look::view_t view{};
  view.utime = ToUtime(capture.frame.time);
  view.step = step_;
  view.index = index;
  view.sequence = static_cast<std::int64_t>(capture.frame.sequence);
  view.reason = reason;
  view.camera = ToMessage(capture.camera_name, capture.camera);
  view.X_WC_measured = ToMessage(capture.X_WC);
  view.X_WC = ToMessage(learned ? belief.views.back().X_WC : capture.X_WC);
  if (learned) view.detections = DetectionsOf(belief, index);
  PostInPieces(channel::kView, std::move(view), &second_look::view_t::detections,
               &second_look::view_t::num_detections);
}

void Publisher::Belief(const world::SceneBelief& belief, Time time) {
  if (Silent()) return;
  if (belief.plane_W) {
    second_look::support_plane_t plane = ToMessage(*belief.plane_W);
    plane.utime = ToUtime(time);
    plane.step = step_;
    Post(channel::kPlane, plane);
  }
  second_look::objects_t objects{};
  objects.utime = ToUtime(time);
  objects.step = step_;
  for (const world::ObjectBelief& object : belief.objects) {
    objects.objects.push_back(ToMessage(object));
  }
  PostInPieces(channel::kObjects, std::move(objects), &second_look::objects_t::objects,
               &second_look::objects_t::num_objects);
}

void Publisher::Map(const world::VoxelSpace& space, Time time) {
  if (Silent() || space.workspace() == nullptr) return;
  second_look::occupancy_t map{};
  map.utime = ToUtime(time);
  map.step = step_;
  map.voxel_m = space.config().voxel_m;
  map.blocks = occupancy_.Since(*space.workspace());
  PostInPieces(channel::kOccupancy, std::move(map), &second_look::occupancy_t::blocks,
               &second_look::occupancy_t::num_blocks);
}

void Publisher::Candidates(const std::vector<world::Look>& looks, Time time) {
  if (Silent()) return;
  second_look::candidates_t candidates{};
  candidates.utime = ToUtime(time);
  candidates.step = step_;
  for (world::Look look : looks) {
    look.arm_motion.knots.clear();  // of hundreds, one is taken
    candidates.looks.push_back(ToMessage(look));
    candidates.looks.back().utime = candidates.utime;
    candidates.looks.back().step = step_;
  }
  PostInPieces(channel::kCandidates, std::move(candidates), &second_look::candidates_t::looks,
               &second_look::candidates_t::num_looks);
}

void Publisher::Look(const world::Look& look, Time time) {
  if (Silent()) return;
  second_look::look_t taken = ToMessage(look);
  taken.utime = ToUtime(time);
  taken.step = step_;
  Post(channel::kLook, taken);
  if (look.path_W.empty()) return;
  second_look::nav_goal_t goal{};
  goal.utime = taken.utime;
  goal.step = step_;
  std::copy_n(taken.X_WB, 3, goal.X_WB);
  goal.path_W = taken.path_W;
  goal.num_path = taken.num_path;
  Post(channel::kNavGoal, goal);
}

void Publisher::NavStatus(int phase, const std::string& reason, const hal::BaseState& base,
                          const hal::PanTiltAngles& head, double metres) {
  if (Silent()) return;
  second_look::nav_status_t status{};
  status.utime = ToUtime(base.time);
  status.step = step_;
  status.phase = static_cast<std::int8_t>(phase);
  status.reason = reason;
  status.X_WB[0] = base.X_WB.x;
  status.X_WB[1] = base.X_WB.y;
  status.X_WB[2] = base.X_WB.yaw;
  status.head[0] = head.pan;
  status.head[1] = head.tilt;
  status.metres = metres;
  Post(channel::kNavStatus, status);
}

void Publisher::Timing(const std::vector<StageTime>& stages, Time time) {
  if (Silent()) return;
  second_look::timing_t timing{};
  timing.utime = ToUtime(time);
  timing.step = step_;
  for (const StageTime& stage : stages) {
    timing.stages.push_back({});
    timing.stages.back().name = stage.name;
    timing.stages.back().robot_seconds = stage.robot_seconds;
    timing.stages.back().wall_seconds = stage.wall_seconds;
  }
  timing.num_stages = static_cast<std::int32_t>(timing.stages.size());
  Post(channel::kTiming, timing);
}

void Publisher::Doing(std::string phase, std::string detail, Time time) {
  const std::scoped_lock lock(mutex_);
  activity_ = {std::move(phase), std::move(detail), step_, time};
}

Activity Publisher::activity() const {
  const std::scoped_lock lock(mutex_);
  return activity_;
}

}  // namespace secondlook::apps
