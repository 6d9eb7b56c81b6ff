#include "tests/drivers/ptu_emulator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <fmt/format.h>

#include "lib/common/numbers.h"

namespace secondlook::hal {
namespace {

constexpr double kArcSecondsPerCount = 185.1428;
constexpr double kRadiansPerCount = kArcSecondsPerCount / 3600.0 * std::numbers::pi / 180.0;
constexpr Duration kStep = Seconds(0.01);

}  // namespace

Time SteppedClock::Now() const {
  const std::scoped_lock lock(mutex_);
  return now_;
}

void SteppedClock::SleepUntil(Time time) {
  std::unique_lock lock(mutex_);
  while (now_ < time) {
    now_ = std::min(time, now_ + kStep);
    // Both axes are asked for in each round, so the fourth answer belongs to a later question.
    const long enough = count_ + 4;
    heard_.wait_for(lock, std::chrono::seconds(2), [&] { return !wait_ || count_ >= enough; });
  }
}

void SteppedClock::Heard() {
  const std::scoped_lock lock(mutex_);
  ++count_;
  heard_.notify_all();
}

void SteppedClock::WaitForOther(bool wait) {
  const std::scoped_lock lock(mutex_);
  wait_ = wait;
  heard_.notify_all();
}

PtuEmulator::PtuEmulator(const Clock* clock, SteppedClock* stepped,
                         const std::filesystem::path& folder)
    : clock_(clock), stepped_(stepped), port_(folder / "ttyPTU") {
  PlugIn();
  thread_ = std::thread([this] { Run(); });
}

PtuEmulator::~PtuEmulator() {
  quit_ = true;
  thread_.join();
  const std::scoped_lock lock(mutex_);
  Unplug();
}

void PtuEmulator::Set(PtuFault fault) {
  const std::scoped_lock lock(mutex_);
  if (fault == PtuFault::kUnplugged) Unplug();
  if (fault_ == PtuFault::kUnplugged && fault != fault_) PlugIn();
  fault_ = fault;
  if (stepped_ == nullptr) return;
  stepped_->WaitForOther(fault == PtuFault::kNone || fault == PtuFault::kGarbage ||
                         fault == PtuFault::kStuck);
}

PanTiltAngles PtuEmulator::target() const {
  const std::scoped_lock lock(mutex_);
  return {pan_.target * kRadiansPerCount, -tilt_.target * kRadiansPerCount};
}

void PtuEmulator::Place(const PanTiltAngles& angles) {
  const std::scoped_lock lock(mutex_);
  placed_ = true;
  pan_.position = angles.pan / kRadiansPerCount;
  tilt_.position = -angles.tilt / kRadiansPerCount;
}

std::string PtuEmulator::last_command() const {
  const std::scoped_lock lock(mutex_);
  return last_command_;
}

void PtuEmulator::PlugIn() {
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  grantpt(master_);
  unlockpt(master_);
  termios settings{};
  tcgetattr(master_, &settings);
  cfmakeraw(&settings);
  tcsetattr(master_, TCSANOW, &settings);
  std::filesystem::remove(port_);
  std::filesystem::create_symlink(ptsname(master_), port_);
  echo_ = true;
  terse_ = false;
  for (Axis* axis : {&pan_, &tilt_}) axis->position = axis->target = 0.0;
  const std::string banner =
      "\r\n### PAN-TILT CONTROLLER v2.13, independent (default) speed control mode 1.5 ###\r\n";
  static_cast<void>(write(master_, banner.data(), banner.size()));
}

void PtuEmulator::Unplug() {
  if (master_ >= 0) close(master_);
  master_ = -1;
  std::filesystem::remove(port_);
}

void PtuEmulator::Run() {
  std::string command;
  while (!quit_) {
    int master = -1;
    {
      const std::scoped_lock lock(mutex_);
      master = master_;
      if (fault_ == PtuFault::kTalks) static_cast<void>(write(master_, "$GPGGA,0915\r\n", 13));
    }
    pollfd waited{master, POLLIN, 0};
    // A port that nobody has opened yet hangs up at once: no reason to spin.
    if (poll(&waited, 1, 5) <= 0 || (waited.revents & POLLIN) == 0) {
      poll(nullptr, 0, 1);
      continue;
    }
    std::array<char, 64> bytes{};
    const ssize_t count = read(master, bytes.data(), bytes.size());
    for (ssize_t i = 0; i < count; ++i) {
      const char c = bytes[static_cast<std::size_t>(i)];
      if (c != ' ' && c != '\r' && c != '\n') {
        command += c;
        continue;
      }
      if (command.empty()) continue;
      const std::scoped_lock lock(mutex_);
      const std::string echo = echo_ ? command + " " : "";
      const std::string answer =
          fault_ == PtuFault::kSilent || fault_ == PtuFault::kTalks ? "" : echo + Answer(command);
      static_cast<void>(write(master_, answer.data(), answer.size()));
      if (stepped_ != nullptr) stepped_->Heard();
      command.clear();
    }
  }
}

void PtuEmulator::Move() {
  const Time now = clock_->Now();
  const double seconds = ToSeconds(now - moved_at_);
  moved_at_ = now;
  if (placed_ || fault_ == PtuFault::kStuck) return;
  for (Axis* axis : {&pan_, &tilt_}) {
    const double most = axis->speed * seconds;
    axis->position += std::clamp(axis->target - axis->position, -most, most);
  }
}

std::string PtuEmulator::Number(const std::string& words, double value) const {
  return terse_ ? fmt::format("* {}\r\n", value) : fmt::format("* {} {}\r\n", words, value);
}

std::string PtuEmulator::Answer(const std::string& command) {
  Move();
  if (fault_ == PtuFault::kGarbage && ++answers_ % 97 == 0) return "\x81\xfe*\x07?\r\n";
  const std::string noise = fault_ == PtuFault::kGarbage ? "\xff\x13!P!T\r\n" : "";
  const std::string done = noise + "*\r\n";
  const bool question = command.size() == 2;
  if (!question || command == "ft" || command == "ed") last_command_ = command;
  if (command == "ft") return terse_ = true, done;
  if (command == "ed") return echo_ = false, done;
  if (command == "ci") return done;
  if (command == "h") {
    for (Axis* axis : {&pan_, &tilt_}) axis->target = axis->position;
    return done;
  }
  if (command == "r") {
    for (Axis* axis : {&pan_, &tilt_}) axis->position = axis->target = 0.0;
    return "!T!T!P!P*\r\n";
  }
  Axis* axis = AxisOf(command[0]);
  if (axis == nullptr || command.size() < 2) return noise + "! Illegal command argument\r\n";
  if (question) {
    switch (command[1]) {
      case 'p':
        return noise + Number("Current position is", std::round(axis->position));
      case 'r':
        return noise + Number("seconds arc per position:", kArcSecondsPerCount);
      case 'n':
        return noise + Number("Minimum position is", axis->lower);
      case 'x':
        return noise + Number("Maximum position is", axis->upper);
      case 'u':
        return noise + Number("Maximum speed is", 2902);
      case 'l':
        return noise + Number("Minimum speed is", 31);
      default:
        return noise + "! Illegal command\r\n";
    }
  }
  const std::optional<double> value = ParseNumber(std::string_view(command).substr(2));
  if (!value) return noise + "! Illegal command argument\r\n";
  if (command[1] == 's') return axis->speed = *value, done;
  if (*value > axis->upper) return noise + "! Maximum allowable position was exceeded\r\n";
  if (*value < axis->lower) return noise + "! Minimum allowable position was exceeded\r\n";
  return axis->target = *value, done;
}

}  // namespace secondlook::hal
