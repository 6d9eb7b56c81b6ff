#pragma once

#include <string>

namespace secondlook {

/// Tells the service manager (systemd) how this process is, as sd_notify(3) does: "READY=1",
/// "WATCHDOG=1", "STATUS=…", "STOPPING=1". Does nothing where no service manager has started the
/// process, or where it does not listen: nobody's motion depends on it.
/// @return false when it was not told.
bool NotifyServiceManager(const std::string& state);

}  // namespace secondlook
