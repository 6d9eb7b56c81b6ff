#include "apps/monitor_server.h"

#include <charconv>
#include <chrono>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/http.h"
#include "apps/page.h"
#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

constexpr const char* kLoopback = "127.0.0.1";

/// The number that a query parameter holds; 0 when it is missing, nothing when it is none.
std::optional<std::uint64_t> NumberOf(const httplib::Request& request, const char* name) {
  const std::string text = request.has_param(name) ? request.get_param_value(name) : "0";
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

bool IsOurs(const httplib::Request& request, int port) {
  if (request.get_header_value_count("Host") != 1) return false;
  const std::string host = request.get_header_value("Host");
  return host == fmt::format("{}:{}", kLoopback, port) || host == fmt::format("localhost:{}", port);
}

void Refuse(int status, std::string why, httplib::Response* response) {
  response->status = status;
  response->set_content(std::move(why), "text/plain; charset=utf-8");
}

/// Without SO_REUSEPORT, by which a second monitor would take every other request of the first.
void KeepPort(int socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

}  // namespace

MonitorServer::MonitorServer(const Story* story, const Listener* listener, int port)
    : story_(story),
      listener_(listener),
      started_(fmt::format("{}", std::chrono::system_clock::now().time_since_epoch().count())),
      http_(std::make_unique<httplib::Server>()) {
  http_->set_socket_options(KeepPort);
  http_->set_keep_alive_max_count(1);  // an open page would keep a thread to itself
  http_->set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"X-Frame-Options", "DENY"},
                              {"Cross-Origin-Resource-Policy", "same-origin"},
                              {"Referrer-Policy", "no-referrer"}});
  http_->set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        if (IsOurs(request, port_)) return httplib::Server::HandlerResponse::Unhandled;
        Refuse(403, fmt::format("This is http://{}:{}/ and nothing else.\n", kLoopback, port_),
               &response);
        return httplib::Server::HandlerResponse::Handled;
      });
  http_->Get("/", [page = LivePage()](const httplib::Request&, httplib::Response& response) {
    response.set_content(page, "text/html; charset=utf-8");
  });
  http_->Get("/messages", [this](const httplib::Request& request, httplib::Response& response) {
    const auto story_number = NumberOf(request, "story");
    const auto from = NumberOf(request, "from");
    if (!story_number || !from) {
      return Refuse(400, "story and from must be whole numbers, 0 or more\n", &response);
    }
    response.set_content(Answer(*story_number, *from), "application/json");
  });
  port_ = port;
  const bool bound = port == 0 ? (port_ = http_->bind_to_any_port(kLoopback)) > 0
                               : http_->bind_to_port(kLoopback, port);
  if (!bound) {
    Throw<ConfigError>(
        "port {} of {}: cannot be had; end what uses it, or choose another with --port", port,
        kLoopback);
  }
  thread_ = std::thread([this] { http_->listen_after_bind(); });
  // stop() would pass a server by that has not begun.
  while (!http_->is_running()) std::this_thread::yield();
}

MonitorServer::~MonitorServer() {
  http_->stop();
  thread_.join();
}

std::string MonitorServer::Answer(std::uint64_t story, std::uint64_t from) const {
  const Heard heard = listener_->heard();
  const StoryPart part = story_->Since(story, from);
  return fmt::format(
      R"({{"server":"{}","story":{},"next":{},"left_out":{},"rejected":{},"last_rejected":{},)"
      R"("status":{},"status_age":{},"messages":{}}})",
      started_, part.story, part.next, part.left_out, heard.rejected,
      nlohmann::json(heard.last_rejected)
          .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
      part.status, heard.status_age ? fmt::format("{:.1f}", *heard.status_age) : "null",
      part.messages);
}

}  // namespace secondlook::apps
