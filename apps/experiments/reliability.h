#pragma once

#include <vector>

#include "apps/experiments/statistics.h"

namespace secondlook::apps {

/// Something that was said to hold with a probability, and whether it does.
struct Prediction {
  double probability{};  ///< In [0, 1].
  bool right{};
};

/// Of a trial, whose predictions are not independent of each other.
using Predictions = std::vector<Prediction>;

constexpr int kReliabilityBins = 10;

/// The share of what is right among what was given a probability in the `bin`-th tenth of [0, 1],
/// from 0; 1 belongs to the last. Where probabilities hold, it lies in that tenth, too.
Estimate ShareRight(const std::vector<Predictions>& trials, int bin);

/// The expected calibration error: the mean over all predictions of the distance, in their tenth,
/// between the mean probability and the share that is right. With the interval of 2000 bootstrap
/// resamples of the trials; NaN without predictions. The same values give the same interval.
Estimate CalibrationError(const std::vector<Predictions>& trials);

/// The Brier score: the mean squared difference between probability and outcome (1 right, 0 wrong),
/// with an interval likewise.
Estimate BrierScore(const std::vector<Predictions>& trials);

}  // namespace secondlook::apps
