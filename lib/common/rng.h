#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace secondlook {

/// The one source of chance. A mission makes one from its seed and hands it, or a fork of it, down;
/// nothing else in the project draws random numbers.
class Rng {
 public:
  explicit Rng(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [low, high). @pre low <= high.
  double Uniform(double low, double high);

  /// Normal with mean 0. @pre sigma >= 0.
  double Gaussian(double sigma);

  /// Uniform in {0, …, count - 1}. @pre count > 0.
  int Index(int count);

  /// 64 random bits.
  std::uint64_t Bits() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

/// A seed for the part called `purpose` of whatever `seed` is for. Parts with different names get
/// independent streams, so that one drawing more does not disturb another.
std::uint64_t ForkSeed(std::uint64_t seed, std::string_view purpose);

}  // namespace secondlook
