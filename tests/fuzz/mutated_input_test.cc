// Whoever reads bytes from outside returns, or throws one of our errors: also on inputs that are
// nearly right. The mutants are the same every time; SECONDLOOK_MUTANTS makes more of them.

#include <cstdint>
#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/fuzz/inputs.h"
#include "tests/support/temporary_folder.h"

namespace secondlook {

/// How GoogleTest names it.
void PrintTo(const OutsideInput& input, std::ostream* out) { *out << input.name; }

namespace {

int MutantsWanted() {
  const char* wanted = std::getenv("SECONDLOOK_MUTANTS");
  return wanted == nullptr ? 200 : std::atoi(wanted);
}

/// `seed` with one to four changes: bits turned, bytes replaced, parts cut out, doubled or moved.
std::string Mutant(std::string text, Rng* rng) {
  static const std::vector<std::string> kTokens{
      "-1", "nan", "1e999", "4294967295", "", "\n", "0x0", " - ", "{}", "\xff\xfe", "99999999"};
  const int changes = 1 + rng->Index(4);
  for (int i = 0; i < changes && !text.empty(); ++i) {
    const auto size = static_cast<int>(text.size());
    const auto at = static_cast<std::size_t>(rng->Index(size));
    const auto length = static_cast<std::size_t>(1 + rng->Index(std::min(size, 24)));
    switch (rng->Index(6)) {
      case 0:
        text[at] = static_cast<char>(text[at] ^ (1 << rng->Index(8)));
        break;
      case 1:
        text[at] = static_cast<char>(rng->Bits());
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, text.substr(static_cast<std::size_t>(rng->Index(size)), length));
        break;
      case 4:
        text.replace(
            at, std::min(length, text.size() - at),
            kTokens[static_cast<std::size_t>(rng->Index(static_cast<int>(kTokens.size())))]);
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

class MutatedInput : public ::testing::TestWithParam<OutsideInput> {};

TEST_P(MutatedInput, IsNoTrouble) {
  const TemporaryFolder folder;
  const OutsideInput& input = GetParam();
  ASSERT_NO_THROW(input.read(input.seed, folder.path()));
  Rng rng(1);
  for (int i = 0; i < MutantsWanted(); ++i) {
    const std::string mutant = Mutant(input.seed, &rng);
    try {
      input.read(mutant, folder.path());
    } catch (const Error&) {
      // It was said what is wrong.
    } catch (const std::exception& error) {
      FAIL() << "mutant " << i << ": " << error.what() << "\n" << mutant;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MutatedInput, ::testing::ValuesIn(OutsideInputs()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace secondlook
