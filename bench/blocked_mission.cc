// How the executive serves while the mission's thread is blocked and all processors compute: STATUS
// over 5 s, and the time from sending a stop to the base's Stop(). Exit status 1 when STATUS is off
// 2 Hz by more than 10 % or a stop takes more than 50 ms.
//   blocked_mission [LCM URL] [threads that compute]
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <future>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/executive.h"
#include "lib/transport/channels.h"
#include "tests/support/fake_robot.h"

#include "second_look/command_t.hpp"

namespace secondlook {
namespace {

namespace channel = transport::channel;
using std::chrono::steady_clock;

constexpr int kStops = 50;

double Milliseconds(steady_clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// Threads that compute all the time, as the mission's do.
class Load {
 public:
  explicit Load(int threads) {
    for (int i = 0; i < threads; ++i) {
      threads_.emplace_back([this] {
        while (!done_) {
        }
      });
    }
  }
  ~Load() {
    done_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  std::atomic<bool> done_{false};
  std::vector<std::thread> threads_;
};

/// A base that notes when it is stopped.
class TimedBase : public testing::FakeBase {
 public:
  TimedBase(testing::FakeWorld* world, std::promise<steady_clock::time_point>* stopped)
      : FakeBase(world), stopped_(stopped) {}
  void Stop() noexcept override { stopped_->set_value(steady_clock::now()); }

 private:
  std::promise<steady_clock::time_point>* stopped_;
};

/// A robot, its executive on `url`, and somebody outside.
struct Rig {
  explicit Rig(const std::string& url) : bus(url) {
    robot.base = std::make_unique<TimedBase>(&world, &stopped);
    if (!url.starts_with("memq")) another.emplace(url);
  }
  /// Who is not the executive. A bus in memory has no other end than itself.
  transport::LcmBus& outside() { return another ? *another : bus; }

  testing::FakeWorld world;
  std::promise<steady_clock::time_point> stopped;
  hal::Robot robot{testing::MakeFakeRobot(&world)};
  apps::DeviceHealth health{robot};
  apps::Publisher publisher;
  transport::LcmBus bus;
  std::optional<transport::LcmBus> another;
  transport::Outbox outbox{apps::Executive::kOutboxBytes};
  apps::ExecutiveParts parts{&bus, &outbox, &robot, &publisher, &health, {}};
};

/// The times between two STATUS over 5 s [ms].
std::vector<double> StatusPeriods(const std::string& url) {
  Rig rig(url);
  std::vector<steady_clock::time_point> heard;
  rig.outside().Listen(channel::kStatus,
                       [&](const transport::Message&) { heard.push_back(steady_clock::now()); });
  std::atomic<bool> done{false};
  std::thread listener([&] {
    while (rig.another && !done) {
      rig.another->Handle();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  {
    apps::Executive executive(rig.parts);
    std::this_thread::sleep_for(std::chrono::milliseconds(5'100));
    done = true;
    listener.join();
  }
  std::vector<double> periods;
  for (std::size_t i = 1; i < heard.size(); ++i) {
    periods.push_back(Milliseconds(heard[i] - heard[i - 1]));
  }
  return periods;
}

/// From sending a stop to the base's Stop() [ms].
double StopLatency(const std::string& url) {
  Rig rig(url);
  auto stopped = rig.stopped.get_future();
  const apps::Executive executive(rig.parts);
  std::this_thread::sleep_for(std::chrono::milliseconds(50 + std::rand() % 20));
  second_look::command_t stop{};
  stop.command = second_look::command_t::STOP;
  const steady_clock::time_point sent = steady_clock::now();
  rig.outside().Publish(transport::Pack(channel::kCommand, stop));
  return Milliseconds(stopped.get() - sent);
}

int Run(const std::string& url, int threads) {
  const Load load(threads);
  const std::vector<double> periods = StatusPeriods(url);
  double sum = 0.0;
  for (const double period : periods) sum += period;
  const double rate = 1e3 * static_cast<double>(periods.size()) / sum;
  fmt::print("STATUS: {:.3f} Hz, {:.0f} to {:.0f} ms apart\n", rate, std::ranges::min(periods),
             std::ranges::max(periods));
  std::vector<double> stops;
  for (int i = 0; i < kStops; ++i) stops.push_back(StopLatency(url));
  std::sort(stops.begin(), stops.end());
  fmt::print("stop: median {:.2f} ms, 90 % within {:.2f} ms, longest {:.2f} ms of {}\n",
             stops[kStops / 2], stops[kStops * 9 / 10], stops.back(), kStops);
  return std::abs(rate - 2.0) <= 0.2 && stops.back() <= 50.0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace secondlook

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  return secondlook::Run(argc > 1 ? argv[1] : "memq://", argc > 2 ? std::atoi(argv[2]) : 2);
}
