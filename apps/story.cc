#include "apps/story.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/page_message.h"
#include "lib/transport/channels.h"
#include "lib/transport/message_json.h"

#include "second_look/nav_status_t.hpp"

namespace secondlook::apps {
namespace {

namespace channel = transport::channel;
using Json = nlohmann::ordered_json;

/// Of the way that was driven, a pose is kept for each such piece of it.
constexpr double kWay_m = 0.04;
constexpr double kTurn = 0.1;  // [rad]

}  // namespace

void Story::Post(const transport::Message& message) {
  const std::string_view type = transport::TypeOn(message.channel);
  if (type.empty()) return;
  const Json body = ForPage(message.channel, transport::ToJson(message.bytes, type));
  if (body.is_null()) return;
  const std::scoped_lock lock(mutex_);
  if (message.channel == channel::kStatus) {
    status_ = body.dump();
    return;
  }
  if (message.channel == channel::kMission) {
    const std::string bytes(message.bytes.begin(), message.bytes.end());
    if (bytes == mission_) return;  // told again
    if (body["end"] == "") Begin();
    mission_ = bytes;
    running_ = body["end"] == "";
    EraseFirst(channel::kMission);
  } else if (CountsAnew(message.channel, body)) {
    Begin();
  }
  if (message.channel == channel::kNavStatus && !Moved(body)) return;
  const int step = body.value("step", 0);
  if (message.channel == channel::kView) viewed_step_ = step;
  if (message.channel == channel::kObjects && body["piece"] == 0) ForgetOldEvidence(step);
  step_ = std::max(step_, step);
  entries_.push_back({next_++, message.channel, step,
                      fmt::format(R"({{"channel":"{}","utime":{},"message":{}}})", message.channel,
                                  body["utime"].get<std::int64_t>(), body.dump())});
  bytes_ += entries_.back().json.size();
  MakeRoom();
}

StoryPart Story::Since(std::uint64_t story, std::uint64_t from) const {
  const std::scoped_lock lock(mutex_);
  StoryPart part{story_, next_, left_out_, "[", status_};
  for (const Entry& entry : entries_) {
    if (story == story_ && entry.number < from) continue;
    if (part.messages.size() > 1) part.messages += ",\n";
    part.messages += entry.json;
  }
  part.messages += "]";
  return part;
}

/// Forgets all but the MISSION message of a mission that has not ended: it comes before the steps.
void Story::Begin() {
  ++story_;
  left_out_ = 0;
  std::erase_if(entries_, [&](const Entry& entry) {
    if (running_ && entry.channel == channel::kMission) return false;
    bytes_ -= entry.json.size();
    return true;
  });
  step_ = viewed_step_ = 0;
  last_pose_ = nullptr;
}

bool Story::CountsAnew(const std::string& channel, const Json& body) const {
  if (!body.contains("step")) return false;
  if (body["step"] < step_) return true;
  return channel == channel::kView && body["piece"] == 0 && body["step"] == viewed_step_;
}

void Story::EraseFirst(const std::string& channel) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& e) { return e.channel == channel; });
  if (found == entries_.end()) return;
  bytes_ -= found->json.size();
  entries_.erase(found);
}

/// True when a pose says something new of the way: far enough from the last one, or the end.
bool Story::Moved(const Json& nav_status) {
  const auto pose = [](const Json& status, int i) {
    const Json& value = status["X_WB"][i];
    return value.is_number() ? value.get<double>() : std::nan("");
  };
  const bool first = last_pose_.is_null() || last_pose_["step"] != nav_status["step"];
  const bool ended = nav_status["phase"] != second_look::nav_status_t::MOVING;
  if (!first && !ended &&
      std::hypot(pose(nav_status, 0) - pose(last_pose_, 0),
                 pose(nav_status, 1) - pose(last_pose_, 1)) < kWay_m &&
      std::abs(pose(nav_status, 2) - pose(last_pose_, 2)) < kTurn) {
    return false;
  }
  last_pose_ = nav_status;
  return true;
}

void Story::ForgetOldEvidence(int step) {
  for (Entry& entry : entries_) {
    if (entry.channel != channel::kObjects || entry.step >= step) continue;
    if (entry.json.find(R"("evidence":[{)") == std::string::npos) continue;
    Json json = Json::parse(entry.json);
    RemoveEvidence(&json["message"]);
    bytes_ -= entry.json.size();
    entry.json = json.dump();
    bytes_ += entry.json.size();
  }
}

void Story::MakeRoom() {
  while (entries_.size() > limits_.messages || bytes_ > limits_.bytes) {
    const auto oldest = std::find_if(entries_.begin(), entries_.end(),
                                     [](const Entry& e) { return e.channel != channel::kMission; });
    if (oldest == entries_.end()) return;
    bytes_ -= oldest->json.size();
    entries_.erase(oldest);
    ++left_out_;
  }
}

}  // namespace secondlook::apps
