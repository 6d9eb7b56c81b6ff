#include "lib/perception/choose_together.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace secondlook::perception {
namespace {

using world::Hypothesis;

constexpr int kProbes = 200;
constexpr float kSkin = 0.008F;      // what touches, as it was measured, stands in less [m]
constexpr double kMostInside = 0.2;  // of the points of either
/// Nearer to each other than this, two of one model are one thing, thin as its walls may be [m].
constexpr double kOnePlace = 0.008;

bool Collide(const std::vector<RecognitionModel>& models, const Hypothesis& a,
             const Hypothesis& b) {
  const RecognitionModel& one = *FindModel(models, a.model);
  const RecognitionModel& two = *FindModel(models, b.model);
  const double apart = (a.X_CM * one.center_M - b.X_CM * two.center_M).norm();
  if (apart > 0.5 * (one.diameter + two.diameter)) return false;
  if (a.model == b.model && apart < kOnePlace) return true;
  return ShareInside(one, a.X_CM, two, b.X_CM) > kMostInside ||
         ShareInside(two, b.X_CM, one, a.X_CM) > kMostInside;
}

/// The detections of a view while they are being chosen from: hypotheses are struck, and keep their
/// index in the original.
class Choosing {
 public:
  Choosing(const std::vector<world::Detection>& detections,
           const std::vector<RecognitionModel>& models, const RecogniseConfig& config)
      : open_(detections), original_(detections.size()), models_(models), config_(config) {
    for (std::size_t d = 0; d < detections.size(); ++d) {
      for (std::size_t h = 0; h < detections[d].hypotheses.size(); ++h) {
        original_[d].push_back(static_cast<int>(h));
      }
    }
    choices_ = ChooseHypotheses(open_, models_, config_);
  }

  std::vector<Choice> Run() {
    // Each round strikes a hypothesis, so it ends.
    while (StrikeOne()) choices_ = ChooseHypotheses(open_, models_, config_);
    for (std::size_t d = 0; d < choices_.size(); ++d) {
      Choice& choice = choices_[d];
      if (choice.hypothesis >= 0) {
        choice.hypothesis = original_[d][static_cast<std::size_t>(choice.hypothesis)];
      } else if (!struck_.empty() && !struck_[d].empty()) {
        choice.reason = struck_[d] + (choice.reason.empty() ? "" : "; then: " + choice.reason);
      }
    }
    return std::move(choices_);
  }

 private:
  const Hypothesis* Chosen(std::size_t d) const {
    const int h = choices_[d].hypothesis;
    return h < 0 ? nullptr : &open_[d].hypotheses[static_cast<std::size_t>(h)];
  }

  /// Strikes the first hypothesis that stands in something that is better supported.
  bool StrikeOne() {
    for (std::size_t winner = 0; winner < open_.size(); ++winner) {
      const Hypothesis* chosen = Chosen(winner);
      if (chosen == nullptr) continue;
      for (std::size_t d = 0; d < open_.size(); ++d) {
        if (d == winner) continue;
        const Hypothesis* other = Chosen(d);
        for (std::size_t h = 0; h < open_[d].hypotheses.size(); ++h) {
          const Hypothesis& loser = open_[d].hypotheses[h];
          if (&loser == other && !Better(*chosen, loser)) continue;
          if (!Collides(winner, choices_[winner].hypothesis, d, static_cast<int>(h))) continue;
          Strike(d, h, *chosen);
          return true;
        }
      }
    }
    return false;
  }

  /// Whether two hypotheses would stand in one another. Each pair is worked out once.
  bool Collides(std::size_t winner, int chosen, std::size_t d, int loser) {
    const auto name = [&](std::size_t detection, int h) {
      return std::pair(detection, original_[detection][static_cast<std::size_t>(h)]);
    };
    const auto [pair, added] = collides_.try_emplace({name(winner, chosen), name(d, loser)});
    if (added) {
      pair->second = Collide(models_, open_[winner].hypotheses[static_cast<std::size_t>(chosen)],
                             open_[d].hypotheses[static_cast<std::size_t>(loser)]);
    }
    return pair->second;
  }

  static bool Better(const Hypothesis& a, const Hypothesis& b) {
    return a.verification.matching > b.verification.matching;
  }

  void Strike(std::size_t d, std::size_t h, const Hypothesis& winner) {
    struck_.resize(open_.size());
    const auto at = static_cast<std::ptrdiff_t>(h);
    if (struck_[d].empty()) {
      const Hypothesis& loser = open_[d].hypotheses[h];
      struck_[d] = loser.model == winner.model
                       ? fmt::format("is a part of the {} beside it", winner.model)
                       : fmt::format("{} (score {:.3f}) would stand in the {} (score {:.3f})",
                                     loser.model, loser.score, winner.model, winner.score);
    }
    open_[d].hypotheses.erase(open_[d].hypotheses.begin() + at);
    original_[d].erase(original_[d].begin() + at);
  }

  std::vector<world::Detection> open_;
  std::vector<std::vector<int>> original_;   // index of each open hypothesis in its detection
  using Name = std::pair<std::size_t, int>;  // detection, hypothesis in the original
  std::map<std::pair<Name, Name>, bool> collides_;
  std::vector<std::string> struck_;  // by detection: what gave way first, and to what
  const std::vector<RecognitionModel>& models_;
  const RecogniseConfig& config_;
  std::vector<Choice> choices_;
};

}  // namespace

double ShareInside(const RecognitionModel& model, const Pose& X_CM, const RecognitionModel& other,
                   const Pose& X_CO) {
  const Pose X_OM = X_CO.inverse() * X_CM;
  Eigen::AlignedBox3f box_O;
  for (const Eigen::Vector3f& p_O : other.hull) box_O.extend(p_O);
  const auto count = std::min<std::size_t>(kProbes, model.points.size());
  int inside = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const ModelPoint& point = model.points[i];
    const Eigen::Vector3d p_MP = (point.point - kSkin * point.normal).cast<double>();
    const Eigen::Vector3f p = (X_OM * p_MP).cast<float>();
    if (!box_O.contains(p)) continue;
    const auto nearest =
        std::min_element(other.points.begin(), other.points.end(),
                         [&](const ModelPoint& one, const ModelPoint& two) {
                           return (one.point - p).squaredNorm() < (two.point - p).squaredNorm();
                         });
    if (nearest->normal.dot(p - nearest->point) < 0.0F) ++inside;
  }
  return count > 0 ? static_cast<double>(inside) / static_cast<double>(count) : 0.0;
}

std::vector<Choice> ChooseTogether(const std::vector<world::Detection>& detections,
                                   const std::vector<RecognitionModel>& models,
                                   const RecogniseConfig& config) {
  return Choosing(detections, models, config).Run();
}

}  // namespace secondlook::perception
