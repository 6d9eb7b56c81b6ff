#include "apps/experiments/nbv_experience.h"

namespace secondlook::apps::nbv {
namespace {

using fusion::FusionRule;

const Decision& Front(const Decisions& decisions, int set, int which) {
  return decisions.Of(FusionRule::kNaiveBayes, set, which).front;
}

}  // namespace

Experience::Experience(const Decisions& decisions, const std::function<bool(int)>& learn) {
  for (int i = 0; i < decisions.set_count(); ++i) {
    if (!learn(i)) continue;
    for (std::size_t s = 0; s < kSideCount; ++s) {
      const std::vector<double> p = decisions.FromSide(i, s).probabilities;
      if (p.empty()) continue;  // it leaves no class possible
      views_.resize(p.size());
      Eigen::MatrixXd& views = views_[decisions.sets()[i].truth][s];
      views.conservativeResize(std::ssize(p), views.cols() + 1);
      views.rightCols(1) = Eigen::Map<const Eigen::VectorXd>(p.data(), std::ssize(p));
    }
  }
}

Eigen::VectorXd Experience::Expected(const std::vector<double>& front) const {
  const Eigen::Map<const Eigen::RowVectorXd> p(front.data(), std::ssize(front));
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(kSideCount);
  for (Eigen::Index c = 0; c < p.size(); ++c) {
    for (std::size_t s = 0; s < kSideCount; ++s) {
      double of_truth = p[c];
      if (c < std::ssize(views_) && views_[c][s].cols() > 0 && p[c] > 0.0) {
        const Eigen::MatrixXd& views = views_[c][s];
        const Eigen::ArrayXd possible = (p * views).transpose();
        of_truth = (p[c] * views.row(c).transpose().array() / possible.max(1e-12)).mean();
      }
      expected[s] += p[c] * of_truth;
    }
  }
  return expected;
}

ExperienceOfOthers::ExperienceOfOthers(const Decisions& decisions) : decisions_(decisions) {
  const std::set<int> blocks = Blocks(decisions);
  for (const int own : blocks) {
    for (const int tested : blocks) {
      const auto learn = [&](int i) {
        const int block = decisions.sets()[i].block;
        return block != own && block != tested;
      };
      without_.try_emplace({own, tested}, decisions, learn);
    }
  }
}

Eigen::VectorXd ExperienceOfOthers::Expected(int set, int which, int tested) const {
  return without_.at({decisions_.sets()[set].block, tested})
      .Expected(Front(decisions_, set, which).probabilities);
}

double ExperienceOfOthers::Promise(int set, int which) const {
  return Expected(set, which, decisions_.sets()[set].block).maxCoeff() -
         Front(decisions_, set, which).confidence;
}

std::set<int> Blocks(const Decisions& decisions) {
  std::set<int> blocks;
  for (const NbvSet& set : decisions.sets()) blocks.insert(set.block);
  return blocks;
}

}  // namespace secondlook::apps::nbv
