#include "lib/common/hash.h"

#include <fmt/format.h>

namespace secondlook {

std::string HexDigits(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

}  // namespace secondlook
