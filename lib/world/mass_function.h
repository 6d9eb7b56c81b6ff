#pragma once

#include <map>
#include <string>

namespace secondlook::world {

/// Belief masses over the classes of the object database (Hoseini 2018, 2.2; the transferable
/// belief model): one per class, one for the whole frame of discernment Omega (ignorance) and one
/// for the empty set (conflict between views). They are >= 0 and sum to 1 (Eq. 1). A class that is
/// not listed has mass 0.
struct MassFunction {
  std::map<std::string, double> singletons;  ///< m({c}) by class.
  double omega{1.0};                         ///< m(Omega): nothing known.
  double conflict{0.0};                      ///< m(empty set).

  /// m({c}); 0 for a class that is not listed.
  double Of(const std::string& c) const {
    const auto found = singletons.find(c);
    return found == singletons.end() ? 0.0 : found->second;
  }
};

}  // namespace secondlook::world
