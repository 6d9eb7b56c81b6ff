#include "lib/world/look.h"

#include "lib/common/error.h"

namespace secondlook::world {

std::string ToString(LookWay way) { return way == LookWay::kArm ? "arm" : "head"; }

LookWay ParseLookWay(const std::string& text) {
  if (text == "head") return LookWay::kHead;
  if (text == "arm") return LookWay::kArm;
  Throw<ProtocolError>("a look by way of '{}' is neither of 'head' and 'arm'", text);
}

}  // namespace secondlook::world
