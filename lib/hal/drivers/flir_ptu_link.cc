#include "lib/hal/drivers/flir_ptu_link.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "lib/common/error.h"
#include "lib/common/numbers.h"

namespace secondlook::hal {
namespace {

constexpr int kTries = 3;
constexpr Duration kPatience = Seconds(0.3);  // between two bytes
constexpr Duration kResetPatience = Seconds(40.0);
constexpr int kMostLines = 50;             // before an answer
constexpr std::size_t kMostUnread = 4096;  // [bytes] of a line

/// The line without what the unit says of its own accord at its beginning.
std::string_view WithoutLimitNotes(std::string_view line) {
  while (line.starts_with("!P") || line.starts_with("!T")) line.remove_prefix(2);
  return line;
}

/// The first number among the words of `text`; empty when there is none.
std::optional<double> FirstNumber(const std::string& text) {
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (const std::optional<double> number = ParseNumber(word)) return number;
  }
  return std::nullopt;
}

bool IsText(std::string_view line) {
  return std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

std::optional<std::string> PtuAnswerIn(std::string_view line, std::string_view command,
                                       bool number) {
  // An echo, where it is still on, stands in front of the answer on the same line.
  if (line.starts_with(std::string(command) + " ")) line.remove_prefix(command.size() + 1);
  const std::string_view answer = WithoutLimitNotes(line);
  if (!IsText(answer) || answer.empty()) return std::nullopt;
  if (answer.starts_with("! ")) {
    Throw<ProtocolError>("the pan-tilt unit refuses '{}': {}", command, answer.substr(2));
  }
  if (answer[0] != '*') return std::nullopt;
  std::string words(answer.substr(1));
  if (number && !FirstNumber(words)) return std::nullopt;
  return words;
}

FlirPtuLink::FlirPtuLink(const std::string& device, int baud)
    : device_(device), port_(device, baud) {
  port_.Write(" ");  // ends whatever half command may wait in the unit
  Do("ft");
  Do("ed");
  Do("ci");
}

void FlirPtuLink::Do(const std::string& command) { Answer(command, false); }

double FlirPtuLink::Ask(const std::string& command) { return *FirstNumber(Answer(command, true)); }

void FlirPtuLink::Reset() {
  port_.Flush();
  unread_.clear();
  port_.Write("r ");
  for (Duration waited{}; waited < kResetPatience; waited += kPatience) {
    if (WithoutLimitNotes(ReadLine()).starts_with('*')) return;
  }
  Throw<DeviceError>(
      "{}: the pan-tilt unit has not found its zero within {:.0f} s: is something in "
      "its way?",
      device_, ToSeconds(kResetPatience));
}

std::string FlirPtuLink::Answer(const std::string& command, bool number) try {
  for (int i = 0; i < kTries; ++i) {
    port_.Flush();
    unread_.clear();
    port_.Write(command + " ");
    // What never stops talking is no pan-tilt unit.
    for (int lines = 0; lines < kMostLines; ++lines) {
      const std::string line = ReadLine();
      if (line.empty()) break;
      if (auto answer = PtuAnswerIn(line, command, number)) return *std::move(answer);
    }
  }
  Throw<DeviceError>(
      "{}: no answer to '{}' from the pan-tilt unit, asked {} times: is it the right port, "
      "powered, "
      "and at this baud rate?",
      device_, command, kTries);
} catch (const ProtocolError& error) {
  Throw<ProtocolError>("{}: {}", device_, error.what());
}

/// The next line that is not empty, without its end; empty when none comes in time.
std::string FlirPtuLink::ReadLine() {
  while (true) {
    const std::size_t end = unread_.find_first_of("\r\n");
    if (end != std::string::npos) {
      std::string line = unread_.substr(0, end);
      unread_.erase(0, end + 1);
      if (!line.empty()) return line;
      continue;
    }
    if (unread_.size() > kMostUnread) return {};
    const std::string bytes = port_.Read(kPatience);
    if (bytes.empty()) return {};
    unread_ += bytes;
  }
}

}  // namespace secondlook::hal
