#include "apps/stop_signal.h"

#include <atomic>
#include <csignal>

namespace secondlook::apps {
namespace {

// A signal handler can reach nothing but a global.
std::atomic<int> stop_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

void Remember(int signal) { stop_signal = signal; }

}  // namespace

void CatchStopSignals() {
  struct sigaction action {};
  action.sa_handler = Remember;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);  // the terminal was closed
  std::signal(SIGXFSZ, SIG_IGN);        // a file that may grow no longer is an error of its writer
}

int StopSignal() { return stop_signal; }

}  // namespace secondlook::apps
