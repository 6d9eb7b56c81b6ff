#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "apps/listener.h"
#include "apps/story.h"

namespace httplib {
class Server;
}

namespace secondlook::apps {

/// Shows a story live to any number of browsers, on 127.0.0.1 alone:
///
///     GET /                          the page
///     GET /messages?story=S&from=N   JSON: {"server", "story", "next", "left_out", "rejected",
///                                    "last_rejected", "status", "status_age", "messages"}
///
/// A browser asks again and again, with the story and the number that the last answer gave; from
/// another story or server it gets all. Nothing can be changed through it. A request whose Host is
/// not this address is refused: a foreign page may have had its name resolved to it.
class MonitorServer {
 public:
  /// Serves until destroyed. `port` 0: any that is free. Both pointers must outlive this.
  /// @throws ConfigError when the port cannot be had.
  MonitorServer(const Story* story, const Listener* listener, int port);
  ~MonitorServer();
  MonitorServer(const MonitorServer&) = delete;
  MonitorServer& operator=(const MonitorServer&) = delete;

  int port() const { return port_; }

 private:
  std::string Answer(std::uint64_t story, std::uint64_t from) const;

  const Story* story_;
  const Listener* listener_;
  std::string started_;  ///< Tells this server from an earlier one at the same address.
  std::unique_ptr<httplib::Server> http_;
  int port_{};
  std::thread thread_;
};

}  // namespace secondlook::apps
