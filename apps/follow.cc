#include "apps/follow.h"

#include <map>
#include <utility>

#include "apps/to_message.h"
#include "lib/transport/channels.h"
#include "lib/transport/json_difference.h"
#include "lib/transport/message_json.h"

namespace secondlook::apps {
namespace {

using second_look::look_t;

std::map<int, look_t> LooksByStep(const hal::Recording& recording) {
  std::map<int, look_t> looks;
  for (const transport::Message& message : recording.told) {
    if (message.channel != transport::channel::kLook) continue;
    look_t look{};
    look.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size()));
    looks[look.step] = std::move(look);
  }
  return looks;
}

/// The look as it would be told at the time and step of `recorded`.
nlohmann::ordered_json AsJson(look_t look, const look_t& recorded) {
  look.utime = recorded.utime;
  look.step = recorded.step;
  return transport::ToJson(transport::Encode(look), "second_look.look_t");
}

TakenLook Recorded(const look_t& message) {
  const world::Look look = FromMessage(message);
  return {look, {look}, ""};
}

std::string Quoted(const std::string& text) { return "\"" + text + "\""; }

}  // namespace

LookChooser FollowLooks(const hal::Recording& recording, DecisionCheck* check) {
  return [looks = LooksByStep(recording), complete = recording.complete, check, step = 0](
             std::optional<TakenLook> own,
             const std::string& end) mutable -> std::optional<TakenLook> {
    const auto found = looks.find(++step);
    const char* channel = transport::channel::kLook;
    if (found == looks.end()) {
      if (!complete) return own;  // it has not got to it
      if (own) check->Differ({step, channel, "", "no look", Quoted(own->look.reason)});
      return std::nullopt;
    }
    const look_t& recorded = found->second;
    if (!own) {
      check->Differ({step, channel, "", Quoted(recorded.reason), "no look, but the end: " + end});
      return Recorded(recorded);
    }
    const auto difference = transport::FirstDifference(AsJson(recorded, recorded),
                                                       AsJson(ToMessage(own->look), recorded));
    if (!difference) return own;
    check->Differ({step, channel, difference->path, difference->a, difference->b});
    TakenLook taken = Recorded(recorded);
    for (world::Look& look : own->candidates) {
      look.chosen = false;
      taken.candidates.push_back(std::move(look));
    }
    return taken;
  };
}

}  // namespace secondlook::apps
