#include "lib/fusion/conclude.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "lib/common/error.h"
#include "lib/fusion/dempster_shafer.h"

namespace secondlook::fusion {
namespace {

using world::ObjectBelief;
using world::ObjectState;
using world::PoseHypothesis;
using world::ViewEvidence;

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// The support that a view gives to a hypothesis.
double SupportOf(const world::Hypothesis& h, const ConcludeConfig& config) {
  return h.verification.accepted ? h.score : std::min(h.score, config.max_unaccepted);
}

double LogOdds(double score) {
  constexpr double kTiny = 1e-12;
  const double bounded = std::clamp(score, kTiny, 1.0 - kTiny);
  return std::log(bounded / (1.0 - bounded));
}

/// The log-odds of a score, whether or not the hypothesis is accepted.
double UncheckedLogOdds(const world::Hypothesis& h) {
  constexpr double kFailedCheck = 2.0;  // what a failed check has taken off (perception::ScoreOf)
  return LogOdds(h.score) + (h.verification.accepted ? 0.0 : kFailedCheck);
}

/// By how much a view prefers `a` to `b`. Where it saw little of them, that little is compared as
/// it is: whether it was just enough to accept one of them is no preference.
double LeadIn(const world::Hypothesis& a, const world::Hypothesis& b,
              const ConcludeConfig& config) {
  const int visible = std::min(a.verification.visible, b.verification.visible);
  if (visible < config.min_objecting_px) return UncheckedLogOdds(a) - UncheckedLogOdds(b);
  return LogOdds(SupportOf(a, config)) - LogOdds(SupportOf(b, config));
}

/// True when some view accepts the hypothesis with colours that agree well enough, and the views
/// that accept it saw most of what all saw.
bool Accepted(const PoseHypothesis& hypothesis, const ConcludeConfig& config) {
  bool clearly = false;
  double accepting = 0.0;
  double all = 0.0;
  for (const ViewEvidence& e : hypothesis.evidence) {
    const world::Verification& v = e.hypothesis.verification;
    if (!v.accepted && v.visible < config.min_objecting_px) continue;
    all += v.visible;
    if (!v.accepted) continue;
    accepting += v.visible;
    if (!(v.color_agreement < config.min_color_agreement)) clearly = true;  // NaN: no colour
  }
  return clearly && accepting >= config.min_accepting * all;
}

/// The share of the pixels that the views saw of it that is in views that accept it.
double AcceptingShare(const PoseHypothesis& hypothesis) {
  double accepting = 0.0;
  double all = 0.0;
  for (const ViewEvidence& e : hypothesis.evidence) {
    const world::Verification& v = e.hypothesis.verification;
    all += v.visible;
    if (v.accepted) accepting += v.visible;
  }
  return all > 0.0 ? accepting / all : 0.0;
}

/// Why it is not accepted: the last objection of a view.
std::string WhyNotAccepted(const PoseHypothesis& hypothesis, const ConcludeConfig& config) {
  for (auto e = hypothesis.evidence.rbegin(); e != hypothesis.evidence.rend(); ++e) {
    const world::Verification& v = e->hypothesis.verification;
    if (!v.accepted) return fmt::format("view {}: {}", e->view, v.reason);
  }
  return fmt::format("its colours agree by {:.2f} (at least {:.2f})",
                     hypothesis.evidence.back().hypothesis.verification.color_agreement,
                     config.min_color_agreement);
}

void Weigh(const ConcludeConfig& config, PoseHypothesis* h) {
  double weight = 0.0;
  double sum = 0.0;
  h->struck = false;
  h->reason.clear();
  const bool held = AcceptingShare(*h) >= config.min_held;
  for (const ViewEvidence& e : h->evidence) {
    const world::Verification& v = e.hypothesis.verification;
    weight += v.visible;
    sum += v.visible * LogOdds(SupportOf(e.hypothesis, config));
    if (!h->struck && !held && v.visible_fraction >= config.strike_visible_fraction &&
        e.hypothesis.score < config.strike_score) {
      h->struck = true;
      h->reason = fmt::format("view {} contradicts it: {}", e.view, v.reason);
    }
  }
  if (!h->struck && h->likely_free >= config.max_likely_free) {
    h->struck = true;
    h->reason = fmt::format("the map contradicts it: {:.0f} % of it lies in likely free space",
                            100.0 * h->likely_free);
  }
  h->support = weight > 0.0 ? 1.0 / (1.0 + std::exp(-sum / weight)) : 0.0;
}

/// The best surviving hypothesis of each class. @pre hypotheses are ordered.
std::map<std::string, const PoseHypothesis*> BestByClass(const ObjectBelief& object) {
  std::map<std::string, const PoseHypothesis*> best;
  for (const PoseHypothesis& h : object.hypotheses) {
    if (!h.struck) best.emplace(h.model, &h);
  }
  return best;
}

world::MassFunction FuseViews(const ObjectBelief& object, const ConcludeConfig& config) {
  const auto best = BestByClass(object);
  std::set<int> views;
  for (const auto& [c, h] : best) {
    for (const ViewEvidence& e : h->evidence) views.insert(e.view);
  }
  world::MassFunction fused;
  for (const int view : views) {
    std::map<std::string, double> supports;
    for (const auto& [c, h] : best) {
      for (const ViewEvidence& e : h->evidence) {
        if (e.view == view) supports[c] = SupportOf(e.hypothesis, config);
      }
    }
    fused = Combine(fused, Discounted(FromSupports(supports), config.view_reliability));
  }
  return fused;
}

/// What shape says, with what the pictures say of it. `refuted`: no model fits, though it should
/// by now.
world::MassFunction Joined(const world::MassFunction& shape, const Appearance& appearance,
                           const ObjectBelief& object, bool refuted) {
  world::MassFunction looks = appearance.masses;
  if (looks.singletons.empty()) return shape;
  for (const auto& [c, h] : BestByClass(object)) {
    if (!looks.singletons.contains(c)) return shape;
  }
  for (auto& [c, mass] : looks.singletons) {
    if (!refuted || appearance.without_model.contains(c)) continue;
    looks.conflict += mass;
    mass = 0.0;
  }
  return Combine(shape, looks);
}

bool HasHypothesis(const ObjectBelief& object, const std::string& c) {
  return std::any_of(object.hypotheses.begin(), object.hypotheses.end(),
                     [&](const PoseHypothesis& h) { return !h.struck && h.model == c; });
}

/// Concludes what leads by the pictures, and no hypothesis stands for; false where nothing does.
/// `fits`: some model does. `seen`: from enough sides.
bool ConcludeByLooks(const world::Task& task, const ConcludeConfig& config,
                     const Appearance& appearance, bool fits, bool seen, ObjectBelief* object) {
  const std::string c = object->LeadingClass();
  if (c.empty() || HasHypothesis(*object, c)) return false;
  const double belief = NormalisedBelief(object->masses, c);
  const double needed = task.ConfidenceFor(c);
  if (!appearance.without_model.contains(c)) {
    if (belief < needed) return false;
    object->reason =
        fmt::format("looks like '{}' at {:.2f}, but its model fits nowhere", c, belief);
    return true;
  }
  if (belief >= needed && seen) {
    object->state = ObjectState::kClassified;
    object->reason = fmt::format("'{}' at {:.3f} by its looks; there is no model of it", c, belief);
    return true;
  }
  const bool unlike_all = NormalisedIgnorance(object->masses) >= config.unknown_ignorance;
  if (belief < needed && (fits || unlike_all)) return false;
  object->reason = fmt::format(
      "looks like '{}' at {:.2f}, of which there is no model; needs {:.2f} from {} sides", c,
      belief, needed, config.unknown_views);
  return true;
}

/// Some view accepts a hypothesis that is still in question.
bool IsAccepted(const ObjectBelief& object) {
  return std::any_of(object.hypotheses.begin(), object.hypotheses.end(),
                     [](const PoseHypothesis& h) { return !h.struck && AcceptingShare(h) > 0.0; });
}

/// Another pose of the best hypothesis's model that the views cannot rule out, or null.
const PoseHypothesis* PoseRival(const ObjectBelief& object, const ConcludeConfig& config) {
  const PoseHypothesis& best = object.hypotheses.front();
  for (const PoseHypothesis& h : object.hypotheses) {
    if (&h == &best || h.struck || h.evidence.empty() || h.model != best.model) continue;
    if (Lead(config, best, h) < NeededLead(config, best, h)) return &h;
  }
  return nullptr;
}

}  // namespace

void ConcludeConfig::Validate() const {
  const auto require = [](const char* name, double value, double least, double most) {
    if (value >= least && value <= most) return;  // false for NaN
    Throw<ConfigError>("{} = {} must be between {} and {}", name, value, least, most);
  };
  constexpr double kMost = 1e9;
  require("strike_visible_fraction", strike_visible_fraction, 0.0, 1.0);
  require("strike_score", strike_score, 0.0, 1.0);
  require("min_held", min_held, 0.0, 1.0);
  require("max_likely_free", max_likely_free, 0.0, 1.0);
  require("max_unaccepted", max_unaccepted, 0.0, 1.0);
  require("min_lead", min_lead, 0.0, kMost);
  require("near_deg", near_deg, 0.0, 180.0);
  require("min_near_lead", min_near_lead, 0.0, kMost);
  require("min_color_agreement", min_color_agreement, 0.0, 1.0);
  require("min_accepting", min_accepting, 0.0, 1.0);
  require("min_objecting_px", min_objecting_px, 0.0, kMost);
  require("view_reliability", view_reliability, 0.0, 1.0);
  require("unknown_views", unknown_views, 1.0, kMost);
  require("unknown_ignorance", unknown_ignorance, 0.0, 1.0);
}

double Lead(const ConcludeConfig& config, const PoseHypothesis& a, const PoseHypothesis& b) {
  double lead = 0.0;
  for (const ViewEvidence& ea : a.evidence) {
    for (const ViewEvidence& eb : b.evidence) {
      if (ea.view == eb.view) lead += LeadIn(ea.hypothesis, eb.hypothesis, config);
    }
  }
  return lead;
}

double NeededLead(const ConcludeConfig& config, const PoseHypothesis& best,
                  const PoseHypothesis& other) {
  const double angle = RotationDistance(best.X_WM.linear(), other.X_WM.linear());
  return angle * kDegrees < config.near_deg ? config.min_near_lead : config.min_lead;
}

void Conclude(const world::Task& task, const ConcludeConfig& config, int clear_views,
              ObjectBelief* object) {
  Conclude(task, config, clear_views, {}, object);
}

void Conclude(const world::Task& task, const ConcludeConfig& config, int clear_views,
              const Appearance& appearance, ObjectBelief* object) {
  for (PoseHypothesis& h : object->hypotheses) Weigh(config, &h);
  std::stable_sort(object->hypotheses.begin(), object->hypotheses.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) {
                     if (a.struck != b.struck) return b.struck;
                     return a.support > b.support;
                   });
  const world::MassFunction shape = FuseViews(*object, config);
  const PoseHypothesis* best = object->Best();
  // Views that refuse all do so for one cause, e.g. wires too thin to be measured: what little they
  // leave does not add up.
  const bool refused = clear_views > config.unknown_views && !IsAccepted(*object);
  const bool fits =
      best != nullptr && !refused && NormalisedIgnorance(shape) < config.unknown_ignorance;
  const bool seen = clear_views >= config.unknown_views;
  object->masses = Joined(shape, appearance, *object, !fits && seen);
  object->state = ObjectState::kCandidate;
  if (ConcludeByLooks(task, config, appearance, fits, seen, object)) return;
  if (!fits) {
    const std::string nearest = best == nullptr
                                    ? "no model in the database fits"
                                    : fmt::format("the nearest model is '{}' with support {:.2f}",
                                                  best->model, best->support);
    if (seen) {
      object->state = ObjectState::kUnknown;
      object->reason =
          fmt::format("{} after {} clear views; m(Omega) = {:.2f}, m(empty) = {:.2f}", nearest,
                      clear_views, object->masses.omega, object->masses.conflict);
    } else {
      object->reason = fmt::format("low confidence: {} in {} clear view{}", nearest, clear_views,
                                   clear_views == 1 ? "" : "s");
    }
    return;
  }

  // The class that the views agree on leads, which need not be that of the single best pose.
  const std::string c = object->LeadingClass();
  std::stable_partition(object->hypotheses.begin(), object->hypotheses.end(),
                        [&](const PoseHypothesis& h) { return !h.struck && h.model == c; });
  best = &object->hypotheses.front();

  const double belief = NormalisedBelief(object->masses, c);
  const double needed = task.ConfidenceFor(c);
  const PoseHypothesis* rival = PoseRival(*object, config);
  if (belief < needed) {
    std::string second;
    double second_mass = 0.0;
    for (const auto& [other, mass] : object->masses.singletons) {
      if (other == c || mass <= second_mass) continue;
      second = other;
      second_mass = mass;
    }
    object->reason =
        second_mass > 0.1 * object->masses.Of(c)
            ? fmt::format("several hypotheses: '{}' at {:.2f}, '{}' at {:.2f}; needs {:.2f}", c,
                          belief, second, NormalisedBelief(object->masses, second), needed)
            : fmt::format("low confidence: '{}' at {:.2f}; needs {:.2f}", c, belief, needed);
  } else if (!Accepted(*best, config)) {
    object->reason = fmt::format("'{}' at {:.2f}, but its pose is not verified: {}", c, belief,
                                 WhyNotAccepted(*best, config));
  } else if (rival != nullptr) {
    object->reason = fmt::format(
        "'{}' at {:.2f}, but its pose is open: two differ by {:.0f} deg "
        "and fit {:.2f} and {:.2f}",
        c, belief, RotationDistance(best->X_WM.linear(), rival->X_WM.linear()) * kDegrees,
        best->support, rival->support);
  } else {
    object->state = ObjectState::kVerified;
    object->reason = fmt::format("'{}' at {:.3f} from {} view{}", c, belief, best->evidence.size(),
                                 best->evidence.size() == 1 ? "" : "s");
  }
}

}  // namespace secondlook::fusion
