#include "lib/common/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace secondlook {
namespace {

/// What a service manager listens on, for as long as this lives.
class Manager {
 public:
  explicit Manager(const std::string& name) : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(name.begin(), name.end(), address.sun_path);
    if (name[0] == '@') address.sun_path[0] = '\0';
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), length), 0);
    setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~Manager() {
    unsetenv("NOTIFY_SOCKET");
    close(fd_);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  std::string Heard() const {
    char text[256];
    const ssize_t size = recv(fd_, text, sizeof(text), 0);
    return size < 0 ? "" : std::string(text, static_cast<std::size_t>(size));
  }

 private:
  int fd_;
};

TEST(ServiceManager, HearsWhatItIsTold) {
  const TemporaryFolder folder;
  const Manager manager((folder.path() / "notify").string());
  EXPECT_TRUE(NotifyServiceManager("READY=1\nWATCHDOG=1"));
  EXPECT_EQ(manager.Heard(), "READY=1\nWATCHDOG=1");
}

TEST(ServiceManager, HearsOnASocketThatIsInNoFileSystem) {
  const Manager manager("@second_look_test_" + std::to_string(getpid()));
  EXPECT_TRUE(NotifyServiceManager("WATCHDOG=1"));
  EXPECT_EQ(manager.Heard(), "WATCHDOG=1");
}

TEST(ServiceManager, IsNotMissedWhereThereIsNone) {
  unsetenv("NOTIFY_SOCKET");
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  setenv("NOTIFY_SOCKET", "/nowhere/notify", 1);
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  setenv("NOTIFY_SOCKET", std::string(300, 'x').c_str(), 1);
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace secondlook
