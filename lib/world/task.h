#pragma once

#include <map>
#include <string>

#include "lib/common/error.h"

namespace secondlook::world {

/// What may be spent on a mission. 0 seconds or metres mean "no limit".
struct Budget {
  int looks = 20;          ///< Views beyond the first.
  double seconds = 600.0;  ///< Robot time.
  double metres = 60.0;    ///< Driven.

  template <class A>
  void Serialize(A* a) {
    a->Visit("looks", &looks);
    a->Visit("seconds", &seconds);
    a->Visit("metres", &metres);
  }
};

/// What a mission is to find out.
struct Task {
  /// Class to the confidence it needs, in (0, 1): "the medicine at 0.99". Empty: everything on the
  /// table. When classes are wanted, what is surely something else needs no further look.
  std::map<std::string, double> wanted;
  double confidence = 0.9;  ///< What a class that is not listed in `wanted` needs.
  Budget budget;

  /// The confidence that an object needs to be called `c`.
  double ConfidenceFor(const std::string& c) const {
    const auto found = wanted.find(c);
    return found == wanted.end() ? confidence : found->second;
  }

  template <class A>
  void Serialize(A* a) {
    a->Visit("wanted", &wanted);
    a->Visit("confidence", &confidence);
    a->Visit("budget", &budget);
  }

  void Validate() const {
    const auto check = [](const std::string& name, double value) {
      if (value > 0.0 && value < 1.0) return;
      Throw<ConfigError>("the confidence for {} is {}; it must lie between 0 and 1", name, value);
    };
    check("a class that is not wanted by name", confidence);
    for (const auto& [name, value] : wanted) check("'" + name + "'", value);
    if (budget.looks < 0) {
      Throw<ConfigError>("budget.looks = {}; it must not be negative", budget.looks);
    }
    // A comparison with NaN is false.
    if (!(budget.seconds >= 0.0)) {
      Throw<ConfigError>("budget.seconds = {}; it must not be negative; 0 means no limit",
                         budget.seconds);
    }
    if (!(budget.metres >= 0.0)) {
      Throw<ConfigError>("budget.metres = {}; it must not be negative; 0 means no limit",
                         budget.metres);
    }
  }
};

}  // namespace secondlook::world
