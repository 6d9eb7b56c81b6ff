#pragma once

#include <string>

#include "lib/hal/base.h"

namespace secondlook::hal {

/// True when `X_WB` is as near to `goal_WB` as Base::Status() calls reached.
bool IsReached(const Pose2& X_WB, const Pose2& goal_WB);

/// Holds `path` to what a base may be asked. @throws InvalidArgument naming the `base` for one
/// without a waypoint, or with one that is not finite.
void CheckPath(const BasePath& path, const std::string& base);

/// "(1.00, -0.50) m, 90 deg".
std::string ToText(const Pose2& X_WB);

}  // namespace secondlook::hal
