#pragma once

#include <vector>

namespace secondlook::apps {

/// A figure with its 95 % confidence interval.
struct Estimate {
  double value{};
  double low{};
  double high{};
};

/// The share of `hits` among `count` with Wilson's score interval; NaN in [0, 1] for count = 0.
Estimate Proportion(int hits, int count);

/// The mean of `values` with the normal interval of its standard error; all NaN for none. With one
/// value the interval is that value.
Estimate Mean(const std::vector<double>& values);

}  // namespace secondlook::apps
