// What libFuzzer calls, in the program `fuzz` of the preset of that name: SECONDLOOK_FUZZ names the
// input. A mistake is a sanitizer's report, or an exception that is none of ours. Bytes that are
// right, to begin with, are written to the file SECONDLOOK_FUZZ_SEED.

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/fuzz/inputs.h"
#include "tests/support/temporary_folder.h"

namespace secondlook {
namespace {

/// @post unless SECONDLOOK_FUZZ names one the process has ended, with the names of all.
OutsideInput Choose() {
  const char* name = std::getenv("SECONDLOOK_FUZZ");
  for (OutsideInput& input : OutsideInputs()) {
    if (name == nullptr || input.name != name) continue;
    if (const char* seed = std::getenv("SECONDLOOK_FUZZ_SEED")) WriteFile(seed, input.seed);
    return std::move(input);
  }
  fmt::print(stderr, "SECONDLOOK_FUZZ must name one of:");
  for (const OutsideInput& input : OutsideInputs()) fmt::print(stderr, " {}", input.name);
  fmt::print(stderr, "\n");
  std::exit(2);
}

const OutsideInput& Chosen() {
  static const OutsideInput input = Choose();
  return input;
}

}  // namespace
}  // namespace secondlook

// What ends here is no finding, as it would be in an input.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  secondlook::Chosen();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const secondlook::TemporaryFolder scratch;
  try {
    secondlook::Chosen().read({reinterpret_cast<const char*>(data), size}, scratch.path());
  } catch (const secondlook::Error&) {
    // It was said what is wrong.
  }
  return 0;
}
