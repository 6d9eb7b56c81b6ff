#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "lib/hal/drivers/serial_port.h"

namespace secondlook::hal {

/// What a line says in answer to `command`, without its '*'; empty when it is no answer, or has no
/// `number` where one was asked for.
/// @throws ProtocolError with the unit's own words when it refuses.
std::optional<std::string> PtuAnswerIn(std::string_view line, std::string_view command,
                                       bool number);

/// The ASCII protocol of FLIR's pan-tilt units (D46, E46): a command ends with a space, its answer
/// is a line that begins with '*' when it was done and with '!' and a space when it was not.
/// Between answers the unit may say "!P" and "!T" (a limit was met) and, after power-up, a banner.
///
/// Answers are kept in step with the commands: whatever came before a command is thrown away, and
/// one that is not answered, or by garbage, is asked again. Threading: one thread.
class FlirPtuLink {
 public:
  /// Opens the port and brings the unit into a known state: terse answers, no echo, positions.
  /// @throws DeviceError when the port cannot be opened or nothing there answers.
  FlirPtuLink(const std::string& device, int baud);

  /// Sends `command` (without its space) and waits for it to be done, 0.3 s and three times at
  /// most.
  /// @throws DeviceError naming the port and the command when no answer comes.
  /// @throws ProtocolError with the unit's own words when it refuses.
  void Do(const std::string& command);

  /// As Do(); the number that the answer holds.
  double Ask(const std::string& command);

  /// Lets the unit find its zero, which takes it up to half a minute: both axes turn to their ends.
  /// @throws DeviceError naming the port when it is not done after 40 s.
  void Reset();

 private:
  std::string Answer(const std::string& command, bool number);
  std::string ReadLine();

  std::string device_;
  SerialPort port_;
  std::string unread_;
};

}  // namespace secondlook::hal
