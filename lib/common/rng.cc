#include "lib/common/rng.h"

#include <cmath>
#include <numbers>

#include "lib/common/hash.h"

namespace secondlook {

// The distributions are written out, since those of the standard library differ between vendors.

double Rng::Uniform(double low, double high) {
  const double unit = static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  return low + (high - low) * unit;
}

double Rng::Gaussian(double sigma) {
  const double u = 1.0 - Uniform(0.0, 1.0);  // (0, 1]: its logarithm is finite
  const double v = Uniform(0.0, 1.0);
  return sigma * std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

int Rng::Index(int count) { return static_cast<int>(Uniform(0.0, 1.0) * count); }

std::uint64_t ForkSeed(std::uint64_t seed, std::string_view purpose) {
  return Fnv1a(purpose, Fnv1a(seed));
}

}  // namespace secondlook
