#pragma once

#include <vector>

namespace secondlook::perception {

/// The probability 1 / (1 + exp(a s + b)) that goes with a score s.
struct PlattSigmoid {
  double a{-1.0};
  double b{0.0};

  double operator()(double score) const;
};

/// The sigmoid of the largest likelihood for scores of which `positive` tells the truth, by
/// Newton's method with backtracking (Platt 2000; Lin, Lin and Weng 2007). Targets are smoothed by
/// the number of samples, so that separable scores do not become certain.
/// @throws InvalidArgument unless there are as many of both, with one positive and one negative.
PlattSigmoid FitPlatt(const std::vector<double>& scores, const std::vector<bool>& positive);

}  // namespace secondlook::perception
