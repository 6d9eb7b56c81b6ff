#include "lib/perception/appearance/platt.h"

#include <algorithm>
#include <cmath>

#include "lib/common/error.h"

namespace secondlook::perception {
namespace {

/// -log likelihood of target t at f = a s + b, without overflow.
double Loss(double t, double f) {
  return f >= 0.0 ? t * f + std::log1p(std::exp(-f)) : (t - 1.0) * f + std::log1p(std::exp(f));
}

}  // namespace

double PlattSigmoid::operator()(double score) const {
  const double f = a * score + b;
  return f >= 0.0 ? std::exp(-f) / (1.0 + std::exp(-f)) : 1.0 / (1.0 + std::exp(f));
}

PlattSigmoid FitPlatt(const std::vector<double>& scores, const std::vector<bool>& positive) {
  const auto positives = static_cast<double>(std::count(positive.begin(), positive.end(), true));
  const double negatives = static_cast<double>(positive.size()) - positives;
  if (scores.size() != positive.size() || positives == 0.0 || negatives == 0.0) {
    Throw<InvalidArgument>("{} scores with {} positive and {} negative; some of both are needed",
                           scores.size(), positives, negatives);
  }
  const double high = (positives + 1.0) / (positives + 2.0);
  const double low = 1.0 / (negatives + 2.0);
  const auto loss = [&](const PlattSigmoid& s) {
    double sum = 0.0;
    for (std::size_t i = 0; i < scores.size(); ++i) {
      sum += Loss(positive[i] ? high : low, s.a * scores[i] + s.b);
    }
    return sum;
  };
  PlattSigmoid fit{0.0, std::log((negatives + 1.0) / (positives + 1.0))};
  double current = loss(fit);
  for (int iteration = 0; iteration < 100; ++iteration) {
    double haa = 1e-12;
    double hbb = 1e-12;
    double hab = 0.0;
    double ga = 0.0;
    double gb = 0.0;
    for (std::size_t i = 0; i < scores.size(); ++i) {
      const double p = fit(scores[i]);
      const double curvature = p * (1.0 - p);
      const double difference = (positive[i] ? high : low) - p;
      haa += scores[i] * scores[i] * curvature;
      hbb += curvature;
      hab += scores[i] * curvature;
      ga += scores[i] * difference;
      gb += difference;
    }
    if (std::abs(ga) < 1e-6 && std::abs(gb) < 1e-6) break;
    const double determinant = haa * hbb - hab * hab;
    const double da = -(hbb * ga - hab * gb) / determinant;
    const double db = -(haa * gb - hab * ga) / determinant;
    double step = 1.0;
    for (; step > 1e-10; step /= 2.0) {
      const PlattSigmoid next{fit.a + step * da, fit.b + step * db};
      const double then = loss(next);
      if (then < current + 1e-4 * step * (ga * da + gb * db)) {
        fit = next;
        current = then;
        break;
      }
    }
    if (step <= 1e-10) break;
  }
  return fit;
}

}  // namespace secondlook::perception
