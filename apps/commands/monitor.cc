#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>

#include "apps/commands/commands.h"
#include "apps/listener.h"
#include "apps/monitor_server.h"
#include "apps/stop_signal.h"
#include "apps/story.h"
#include "lib/common/error.h"
#include "lib/transport/lcm_bus.h"

namespace secondlook::apps {
namespace {

struct MonitorOptions {
  std::string lcm_url{transport::kDefaultLcmUrl};
  int port{8420};
};

/// How long the loop may be deaf to a stop signal [ms].
constexpr int kPatience_ms = 200;

int Watch(const MonitorOptions& options) {
  CatchStopSignals();
  lcm::LCM lcm(options.lcm_url);
  if (!lcm.good()) {
    Throw<ConfigError>(
        "--lcm-url {}: LCM cannot be opened; where the machine has no route for multicast, add "
        "one: "
        "ip route add 224.0.0.0/4 dev lo",
        options.lcm_url);
  }
  Story story;
  Listener listener(&lcm, &story);
  const MonitorServer server(&story, &listener, options.port);
  fmt::print("http://127.0.0.1:{}/ shows the mission that is heard on {}; Ctrl-C ends this\n",
             server.port(), options.lcm_url);
  std::fflush(stdout);
  while (StopSignal() == 0) {
    errno = 0;
    if (lcm.handleTimeout(kPatience_ms) < 0 && errno != EINTR) {
      Throw<DeviceError>("--lcm-url {}: LCM has failed: {}", options.lcm_url, std::strerror(errno));
    }
  }
  return 128 + StopSignal();
}

}  // namespace

void AddMonitor(CLI::App* app, int* status) {
  CLI::App* monitor = app->add_subcommand("monitor", "Shows a running mission in a browser");
  const auto options = std::make_shared<MonitorOptions>();  // outlives this function
  monitor->add_option("--lcm-url", options->lcm_url, "LCM network to listen to")
      ->capture_default_str();
  monitor->add_option("--port", options->port, "On 127.0.0.1; 0: any that is free")
      ->check(CLI::Range(0, 65535));
  monitor->callback([options, status] { *status = Watch(*options); });
}

}  // namespace secondlook::apps
