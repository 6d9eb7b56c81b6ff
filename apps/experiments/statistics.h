#pragma once

#include <functional>
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

/// `figure` of the trials 0 … count - 1, with the interval of 2000 bootstrap resamples of them; all
/// NaN for none. The same figures give the same interval.
Estimate Bootstrapped(int count, const std::function<double(const std::vector<int>&)>& figure);

/// The mean of differences `values` between two methods in the same trials, with the interval of
/// 2000 bootstrap resamples of the trials; all NaN for none. The same values give the same
/// interval.
Estimate BootstrappedMean(const std::vector<double>& values);

/// The ratio of the sums of `numerators` and `denominators`, one of each a trial, likewise.
/// @pre as many of the one as of the other.
Estimate BootstrappedRatio(const std::vector<double>& numerators,
                           const std::vector<double>& denominators);

}  // namespace secondlook::apps
