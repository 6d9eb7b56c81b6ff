#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <string>

#include <nlohmann/json.hpp>

#include "lib/transport/message.h"

namespace secondlook::apps {

/// How much of a mission is kept.
struct StoryLimits {
  std::size_t messages{20'000};
  std::size_t bytes{64'000'000};
};

/// A part of a story, in the order it was told.
struct StoryPart {
  std::uint64_t story{};     ///< Which story this is: 1, 2, …
  std::uint64_t next{};      ///< What to ask for next.
  std::uint64_t left_out{};  ///< Older messages that no longer fit.
  std::string messages;      ///< JSON: a list of {"channel", "utime", "message"}.
  std::string status;        ///< JSON: the newest STATUS message, or null.
};

/// What one mission has told, as much of it as the page needs. A new mission begins a new story:
/// its MISSION message, or steps that count from 1 again.
///
/// Threading: from any thread.
class Story : public transport::Sink {
 public:
  explicit Story(const StoryLimits& limits = {}) : limits_(limits) {}

  /// Takes a message; one that the page does not need is passed over. What no longer fits pushes
  /// the oldest out. @throws ProtocolError when its bytes are not what its channel carries.
  void Post(const transport::Message& message) override;

  /// The messages from number `from` on; all of them when `story` is not the present one.
  StoryPart Since(std::uint64_t story, std::uint64_t from) const;
  StoryPart All() const { return Since(0, 0); }

 private:
  struct Entry {
    std::uint64_t number{};
    std::string channel;
    int step{};
    std::string json;
  };

  void Begin();
  bool CountsAnew(const std::string& channel, const nlohmann::ordered_json& body) const;
  void EraseFirst(const std::string& channel);
  bool Moved(const nlohmann::ordered_json& nav_status);
  void ForgetOldEvidence(int step);
  void MakeRoom();

  StoryLimits limits_;
  mutable std::mutex mutex_;  // of all that follows
  std::uint64_t story_{1};
  std::uint64_t next_{};
  std::uint64_t left_out_{};
  std::size_t bytes_{};
  std::deque<Entry> entries_;
  std::string status_{"null"};
  std::string mission_;  // the newest MISSION message, encoded
  bool running_{};       // it says that the mission has not ended
  int step_{};           // the newest
  int viewed_step_{};    // of the newest VIEW
  nlohmann::ordered_json last_pose_;
};

}  // namespace secondlook::apps
