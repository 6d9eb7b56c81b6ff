#pragma once

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "lib/hal/replay/recording.h"
#include "lib/transport/message.h"

namespace secondlook::apps {

/// Where a mission decided or believed otherwise than a recorded one.
struct Difference {
  int step{};            ///< Of the cycle, from 1.
  std::string channel;   ///< The message in which it shows.
  std::string field;     ///< Its path in the message; empty: the whole message.
  std::string recorded;  ///< What the recorded mission told there …
  std::string present;   ///< … and what this one tells.
};

/// "step 3, SECONDLOOK_LOOK, 'target': recorded 4, now 2"
std::string ToText(const Difference& difference);

/// Compares what a mission tells with what a recorded one told: its views, planes, objects, map,
/// candidates, looks and goals, and how it ended. For each step and channel the first difference is
/// kept. Images, times taken and how a motion goes are no decisions.
class DecisionCheck : public transport::Sink {
 public:
  explicit DecisionCheck(const hal::Recording& recording);

  void Post(const transport::Message& message) override;

  /// Notes a difference, unless its step and channel have one.
  void Differ(Difference difference);

  /// In the order in which they were found.
  const std::vector<Difference>& differences() const { return differences_; }

  int compared() const { return compared_; }

 private:
  using Key = std::pair<int, std::string>;  // step and channel

  void FinishUpTo(int step, const std::string& present);

  bool complete_{};
  int last_recorded_step_{};
  std::map<Key, std::deque<nlohmann::ordered_json>> recorded_;  // and not yet told
  int step_{};
  int compared_{};
  std::vector<Difference> differences_;
};

}  // namespace secondlook::apps
