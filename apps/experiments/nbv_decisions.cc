#include "apps/experiments/nbv_decisions.h"

#include <algorithm>

namespace secondlook::apps::nbv {

using fusion::FusionRule;

Decisions::Decisions(const std::vector<NbvSet>& sets, const NbvClassifier& classifier)
    : sets_(sets), classifier_(classifier) {
  for (const auto& [rule, name] : kRules) {
    auto& decided = decided_[rule];
    for (const NbvSet& set : sets) {
      auto& cases = decided.emplace_back();
      for (const NbvCase& one : set.cases) cases.push_back(Decide(rule, set, one));
    }
  }
}

Decision Decisions::FromSide(int set, std::size_t side) const {
  constexpr FusionRule kRule = FusionRule::kNaiveBayes;
  const fusion::ViewDecision view = View(sets_[set].sides[side], kRule);
  return DecisionOf(FuseDecisions(kRule, {view}).probabilities, sets_[set].truth);
}

std::vector<Shared> Decisions::Result(FusionRule rule, const Chooser& chooser, int set, int which,
                                      double gate) const {
  const Decided& decided = Of(rule, set, which);
  if (!(decided.front.ratio < gate)) return {{1.0, &decided.front}};
  std::vector<Shared> shared;
  const Choice choice = chooser(set, which);
  for (std::size_t s = 0; s < kSideCount; ++s) {
    if (choice[s] > 0.0) shared.push_back({choice[s], &decided.with[s]});
  }
  return shared;
}

std::vector<double> Decisions::Right(FusionRule rule, const Chooser& chooser, double gate,
                                     int wanted) const {
  std::vector<double> right(sets_.size(), 0.0);
  for (int i = 0; i < set_count(); ++i) {
    for (int k = 0; k < std::ssize(sets_[i].cases); ++k) {
      if (wanted >= 0 && sets_[i].cases[k].distortion != wanted) continue;
      for (const Shared& s : Result(rule, chooser, i, k, gate)) {
        if (s.decision->said == sets_[i].truth) right[i] += s.share;
      }
    }
  }
  return right;
}

std::vector<double> Decisions::Count(int wanted) const {
  std::vector<double> count;
  for (const NbvSet& set : sets_) {
    count.push_back(static_cast<double>(
        std::count_if(set.cases.begin(), set.cases.end(),
                      [&](const NbvCase& one) { return wanted < 0 || one.distortion == wanted; })));
  }
  return count;
}

double Decisions::Conflict(int front_set, int which, int side_set, std::size_t side) const {
  constexpr FusionRule kRule = FusionRule::kNaiveBayes;  // nothing discounted
  return FuseDecisions(kRule, {View(sets_[front_set].cases[which].front, kRule),
                               View(sets_[side_set].sides[side], kRule)})
      .masses.conflict;
}

fusion::ViewDecision Decisions::View(const std::vector<double>& probabilities,
                                     FusionRule rule) const {
  fusion::ViewDecision view;
  view.masses.omega = 0.0;
  for (std::size_t c = 0; c < probabilities.size(); ++c) {
    if (classifier_.classes[c] == "unknown") {
      view.masses.omega = probabilities[c];
    } else {
      view.masses.singletons[classifier_.classes[c]] = probabilities[c];
    }
  }
  if (rule == FusionRule::kTransferableBelief) view.reliability = classifier_.reliability;
  return view;
}

Decision Decisions::DecisionOf(const std::map<std::string, double>& p, int truth) const {
  const std::string said = fusion::MostProbable(p);
  if (said.empty()) return {-1, 0.0, 0.0, 0.0, {}};  // total conflict
  const auto& classes = classifier_.classes;
  std::vector<double> by_class;
  for (const std::string& c : classes) by_class.push_back(p.contains(c) ? p.at(c) : 0.0);
  return {static_cast<int>(std::find(classes.begin(), classes.end(), said) - classes.begin()),
          p.at(said), p.at(classes[truth]), fusion::ConfidenceRatio(p), by_class};
}

Decided Decisions::Decide(FusionRule rule, const NbvSet& set, const NbvCase& one) const {
  const fusion::ViewDecision front = View(one.front, rule);
  Decided decided;
  decided.front = DecisionOf(FuseDecisions(rule, {front}).probabilities, set.truth);
  for (std::size_t s = 0; s < kSideCount; ++s) {
    const fusion::ViewDecision side = View(set.sides[s], rule);
    decided.with[s] = DecisionOf(FuseDecisions(rule, {front, side}).probabilities, set.truth);
  }
  return decided;
}

}  // namespace secondlook::apps::nbv
