#pragma once

#include <string>
#include <string_view>

#include "lib/common/time.h"

namespace secondlook::hal {

/// A serial port as a line of bytes: 8 data bits, no parity, one stop bit, no flow control, nothing
/// translated. Closed by its destructor. Threading: one thread.
class SerialPort {
 public:
  /// Opens `device`, e.g. /dev/ttyUSB0, for this process alone.
  /// @param baud 9600, 19200, 38400, 57600 or 115200.
  /// @throws DeviceError naming the device, the system's reason and what to do about it.
  /// @throws ConfigError for another baud rate.
  SerialPort(const std::string& device, int baud);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Hands `bytes` to the system, all of them.
  /// @throws DeviceError naming the device when it is gone or takes nothing for a second.
  void Write(std::string_view bytes);

  /// What has come in, waiting up to `timeout` >= 0 (of the machine, not of the robot) for a first
  /// byte; empty when none came. @throws DeviceError naming the device when it is gone.
  std::string Read(Duration timeout);

  /// Throws away what has come in and was not read.
  void Flush();

 private:
  bool WaitFor(short events, Duration timeout) const;

  std::string device_;
  int descriptor_{-1};
};

}  // namespace secondlook::hal
