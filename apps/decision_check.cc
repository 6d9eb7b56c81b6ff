#include "apps/decision_check.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

#include "lib/common/error.h"
#include "lib/transport/channels.h"
#include "lib/transport/json_difference.h"
#include "lib/transport/message_json.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
namespace channel = transport::channel;

constexpr std::array<std::string_view, 8> kDecisions{
    channel::kView,       channel::kPlane, channel::kObjects, channel::kOccupancy,
    channel::kCandidates, channel::kLook,  channel::kNavGoal, channel::kMission};

/// The end of a mission comes after all its steps.
constexpr int kEnd = std::numeric_limits<int>::max();

/// What of a message is compared; null for one that is no decision.
Json DecisionIn(const transport::Message& message) {
  if (std::find(kDecisions.begin(), kDecisions.end(), message.channel) == kDecisions.end()) {
    return nullptr;
  }
  Json body = transport::ToJson(message.bytes, transport::TypeOn(message.channel));
  if (message.channel != channel::kMission) return body;
  if (body["end"] == "") return nullptr;
  // Another version of the program may decide alike, and paths depend on where it runs.
  body.erase("version");
  body.erase("config");
  return body;
}

int StepOf(const Json& body) { return body.value("step", kEnd); }

}  // namespace

std::string ToText(const Difference& difference) {
  const std::string field = difference.field.empty() ? "" : fmt::format(", '{}'", difference.field);
  return fmt::format("step {}, {}{}: recorded {}, now {}", difference.step, difference.channel,
                     field, difference.recorded, difference.present);
}

DecisionCheck::DecisionCheck(const hal::Recording& recording) : complete_(recording.complete) {
  for (const transport::Message& message : recording.told) {
    Json body = DecisionIn(message);
    if (body.is_null()) continue;
    const int step = StepOf(body);
    last_recorded_step_ = std::max(last_recorded_step_, step);
    recorded_[{step, message.channel}].push_back(std::move(body));
  }
}

void DecisionCheck::Post(const transport::Message& message) {
  const Json present = DecisionIn(message);
  if (present.is_null()) return;
  const int step = StepOf(present);
  if (step == kEnd) {
    FinishUpTo(kEnd, "nothing, but the end: " + present["end"].get<std::string>());
  } else if (step > step_) {
    FinishUpTo(step, "nothing");
  }
  if (step != kEnd) step_ = step;
  auto& recorded = recorded_[{step, message.channel}];
  if (recorded.empty()) {
    // A recording that ends early has not got to it.
    if (!complete_ && step >= last_recorded_step_) return;
    Differ({step_, message.channel, "", "nothing", "a message"});
    return;
  }
  ++compared_;
  if (const auto d = transport::FirstDifference(recorded.front(), present)) {
    Differ({step_, message.channel, d->path, d->a, d->b});
  }
  recorded.pop_front();
}

void DecisionCheck::Differ(Difference difference) {
  const bool known =
      std::any_of(differences_.begin(), differences_.end(), [&](const Difference& d) {
        return d.step == difference.step && d.channel == difference.channel;
      });
  if (!known) differences_.push_back(std::move(difference));
}

/// What was recorded before `step` and not told until now is missing: there is `present` instead.
void DecisionCheck::FinishUpTo(int step, const std::string& present) {
  for (const auto& [key, messages] : recorded_) {
    if (key.first >= step || messages.empty()) continue;
    Differ({key.first, key.second, "", "a message", present});
  }
  std::erase_if(recorded_, [&](const auto& entry) { return entry.first.first < step; });
}

}  // namespace secondlook::apps
