#include "lib/hal/drivers/serial_port.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <map>

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

const char* AdviceFor(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return ": is it plugged in, and powered?";
    case EACCES:
      return ": let this user have the port (group dialout)";
    case EBUSY:
      return ": another program has it";
    default:
      return "";
  }
}

speed_t SpeedOf(const std::string& device, int baud) {
  static const std::map<int, speed_t> kSpeeds{
      {9600, B9600}, {19200, B19200}, {38400, B38400}, {57600, B57600}, {115200, B115200}};
  const auto found = kSpeeds.find(baud);
  if (found == kSpeeds.end()) {
    Throw<ConfigError>("{}: {} baud: expected 9600, 19200, 38400, 57600 or 115200", device, baud);
  }
  return found->second;
}

/// 8N1, raw: termios as cfmakeraw() leaves it, no modem lines.
bool Configure(int descriptor, speed_t speed) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) return false;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB | PARENB);
  cfsetispeed(&settings, speed);
  cfsetospeed(&settings, speed);
  return tcsetattr(descriptor, TCSANOW, &settings) == 0;
}

}  // namespace

SerialPort::SerialPort(const std::string& device, int baud) : device_(device) {
  const speed_t speed = SpeedOf(device, baud);
  descriptor_ = open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ >= 0 && ioctl(descriptor_, TIOCEXCL) == 0 && Configure(descriptor_, speed)) {
    return;
  }
  const int error = errno;
  if (descriptor_ >= 0) close(descriptor_);
  Throw<DeviceError>("{}: cannot be opened: {}{}", device_, std::strerror(error), AdviceFor(error));
}

SerialPort::~SerialPort() { close(descriptor_); }

bool SerialPort::WaitFor(short events, Duration timeout) const {
  pollfd waited{descriptor_, events, 0};
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  const int ready = poll(&waited, 1, static_cast<int>(ms));
  if (ready < 0 && errno != EINTR) {
    Throw<DeviceError>("{}: is lost: {}", device_, std::strerror(errno));
  }
  if (ready > 0 && (waited.revents & events) == 0) {
    Throw<DeviceError>("{}: is lost: it hung up; was it unplugged?", device_);
  }
  return ready > 0;
}

void SerialPort::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    if (!WaitFor(POLLOUT, Seconds(1.0))) {
      Throw<DeviceError>("{}: takes no more bytes; {} were not sent", device_, bytes.size());
    }
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno != EAGAIN && errno != EINTR) {
      Throw<DeviceError>("{}: is lost: {}", device_, std::strerror(errno));
    }
    if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::string SerialPort::Read(Duration timeout) {
  if (!WaitFor(POLLIN, timeout)) return {};
  std::array<char, 256> bytes{};
  const ssize_t count = read(descriptor_, bytes.data(), bytes.size());
  if (count > 0) return {bytes.data(), static_cast<std::size_t>(count)};
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return {};
  Throw<DeviceError>("{}: is lost: {}", device_,
                     count == 0 ? "it hung up; was it unplugged?" : std::strerror(errno));
}

void SerialPort::Flush() { tcflush(descriptor_, TCIFLUSH); }

}  // namespace secondlook::hal
