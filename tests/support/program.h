#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

namespace secondlook::testing {

/// What a program left behind.
struct ProgramResult {
  int status{};  ///< As a shell says it: 128 + n when signal n ended it.
  std::string out;
  std::string err;
};

/// A signal that is sent once standard error holds `after`.
struct SignalAfter {
  std::string after;
  int signal{};  ///< 0: none.
};

/// Runs the program under test with `arguments` and waits for its end.
inline ProgramResult RunProgram(const std::vector<std::string>& arguments,
                                SignalAfter signal = {"", 0}) {
  std::array<int, 2> out{};
  std::array<int, 2> err{};
  if (pipe2(out.data(), O_CLOEXEC) != 0 || pipe2(err.data(), O_CLOEXEC) != 0) std::abort();
  std::vector<char*> argv{const_cast<char*>(SECONDLOOK_PROGRAM)};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    execv(SECONDLOOK_PROGRAM, argv.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  ProgramResult result;
  std::array<pollfd, 2> ends{{{out[0], POLLIN, 0}, {err[0], POLLIN, 0}}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    poll(ends.data(), ends.size(), -1);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      std::array<char, 4096> buffer{};
      const ssize_t count = read(ends[i].fd, buffer.data(), buffer.size());
      if (count <= 0) {
        close(ends[i].fd);
        ends[i].fd = -1;
        continue;
      }
      (i == 0 ? result.out : result.err).append(buffer.data(), static_cast<std::size_t>(count));
    }
    if (signal.signal != 0 && result.err.find(signal.after) != std::string::npos) {
      kill(child, signal.signal);
      signal.signal = 0;
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace secondlook::testing
