#pragma once

#include <functional>
#include <vector>

#include "lib/planning/expected_loss.h"

namespace secondlook::planning {

/// A look that may be taken.
struct LookOption {
  double seconds{};                 ///< It takes, > 0.
  std::vector<Prospect> prospects;  ///< What it may show.
};

/// What a look is worth after another one.
struct Sequel {
  double seconds{};  ///< It takes from there, > 0.
  double share{};    ///< Of its evidence that the first has not given already, in [0, 1].
};

/// By hand: as many pairs as leave the choice of a look within its time.
struct LookAheadConfig {
  int firsts{6};   ///< So many looks, the best by themselves, are looked beyond …
  int seconds{8};  ///< … to so many.

  template <class A>
  void Serialize(A* a) {
    a->Visit("firsts", &firsts);
    a->Visit("seconds", &seconds);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// For each of `options` the gain per second of the best plan that begins with it: the look alone,
/// or followed by a second one where the first turned out such that the second pays. A look that
/// settles nothing by itself can still be the first of the best two. Branch and bound: a first look
/// that could not win if everything were settled after it is not looked beyond.
std::vector<double> GainsLookingAhead(const Belief& prior, const std::vector<LookOption>& options,
                                      const std::function<Sequel(int first, int second)>& after,
                                      const LossConfig& loss, const LookAheadConfig& config);

}  // namespace secondlook::planning
