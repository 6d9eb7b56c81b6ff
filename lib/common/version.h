#pragma once

namespace secondlook {

/// Of this program; the same as in CMakeLists.txt, which a test of the docs holds it to.
inline constexpr const char* kVersion = "0.1.0";

}  // namespace secondlook
