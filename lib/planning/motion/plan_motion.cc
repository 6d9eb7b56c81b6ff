#include "lib/planning/motion/plan_motion.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/terminationconditions/IterationTerminationCondition.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/planning/motion/stop_and_go.h"

namespace secondlook::planning {
namespace {

namespace ob = ompl::base;
using Space = ob::RealVectorStateSpace;
using Waypoints = std::vector<Eigen::VectorXd>;

constexpr double kDegrees = 180.0 / std::numbers::pi;

Eigen::Map<const Eigen::VectorXd> Angles(const ob::State* state, int size) {
  return {state->as<Space::StateType>()->values, size};
}

/// Draws states from our own generator.
class SeededSampler : public ob::StateSampler {
 public:
  SeededSampler(const ob::StateSpace* space, Rng* rng) : StateSampler(space), seeded_(*rng) {}

  void sampleUniform(ob::State* state) override {
    const ob::RealVectorBounds& bounds = space_->as<Space>()->getBounds();
    for (std::size_t i = 0; i < bounds.low.size(); ++i) {
      Value(state, i) = seeded_.Uniform(bounds.low[i], bounds.high[i]);
    }
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    for (std::size_t i = 0; i < space_->getDimension(); ++i) {
      Value(state, i) =
          near->as<Space::StateType>()->values[i] + seeded_.Uniform(-distance, distance);
    }
    space_->enforceBounds(state);
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double sigma) override {
    for (std::size_t i = 0; i < space_->getDimension(); ++i) {
      Value(state, i) = mean->as<Space::StateType>()->values[i] + seeded_.Gaussian(sigma);
    }
    space_->enforceBounds(state);
  }

 private:
  static double& Value(ob::State* state, std::size_t i) {
    return state->as<Space::StateType>()->values[i];
  }

  Rng& seeded_;
};

/// Straight ways as StraightIsFree() has them.
class DenseValidator : public ob::MotionValidator {
 public:
  DenseValidator(const ob::SpaceInformationPtr& space, const ArmCollision& collision, double step_m)
      : MotionValidator(space), collision_(collision), step_m_(step_m) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    const int size = collision_.chain().size();
    return StraightIsFree(collision_, Angles(a, size), Angles(b, size), step_m_);
  }
  bool checkMotion(const ob::State* a, const ob::State* b,
                   std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(a, b)) return true;
    last_valid.second = 0.0;
    if (last_valid.first != nullptr) si_->copyState(last_valid.first, a);
    return false;
  }

 private:
  const ArmCollision& collision_;
  double step_m_;
};

/// The way that RRT-Connect finds; empty when it finds none.
Waypoints SearchWay(const ArmCollision& collision, const Eigen::VectorXd& start,
                    const Eigen::VectorXd& goal, Rng* rng, const MotionConfig& config) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  const kinematics::Chain& chain = collision.chain();
  const int size = chain.size();
  const auto space = std::make_shared<Space>(size);
  for (int i = 0; i < size; ++i) {
    space->setDimensionName(i, chain.joint(i).name);
    ob::RealVectorBounds bounds = space->getBounds();
    bounds.setLow(i, chain.joint(i).lower);
    bounds.setHigh(i, chain.joint(i).upper);
    space->setBounds(bounds);
  }
  space->setStateSamplerAllocator(
      [rng](const ob::StateSpace* of) { return std::make_shared<SeededSampler>(of, rng); });
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      [&](const ob::State* state) { return collision.Free(Angles(state, size)); });
  information->setMotionValidator(
      std::make_shared<DenseValidator>(information, collision, config.step_m));
  information->setup();

  ob::ScopedState<Space> from(space);
  ob::ScopedState<Space> to(space);
  for (int i = 0; i < size; ++i) {
    from[i] = start[i];
    to[i] = goal[i];
  }
  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  problem->setStartAndGoalStates(from, to);
  ompl::geometric::RRTConnect planner(information);
  planner.setRange(config.range);
  planner.setProblemDefinition(problem);
  // The default structure draws random numbers of its own.
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setup();
  ob::IterationTerminationCondition limit(static_cast<unsigned>(config.iterations));
  if (planner.solve(limit) != ob::PlannerStatus::EXACT_SOLUTION) return {};
  Waypoints way;
  for (const ob::State* state :
       problem->getSolutionPath()->as<ompl::geometric::PathGeometric>()->getStates()) {
    way.emplace_back(Angles(state, size));
  }
  way.front() = start;
  way.back() = goal;
  return way;
}

/// The point of the way that lies `share` of [0, 1] along it, each straight piece counting alike.
struct Place {
  std::size_t piece;
  Eigen::VectorXd q;
};

Place PlaceOn(const Waypoints& way, double share) {
  const double along = share * static_cast<double>(way.size() - 1);
  const auto piece = std::min(static_cast<std::size_t>(along), way.size() - 2);
  const double rest = along - static_cast<double>(piece);
  return {piece, (1.0 - rest) * way[piece] + rest * way[piece + 1]};
}

double SecondsAlong(const Waypoints& way, const std::vector<hal::JointInfo>& joints) {
  double seconds = 0.0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    seconds += SecondsBetween(way[i - 1], way[i], joints);
  }
  return seconds;
}

/// Replaces what lies between two random places by the straight way where that is free and quicker.
void Shorten(const ArmCollision& collision, const std::vector<hal::JointInfo>& joints, Rng* rng,
             const MotionConfig& config, Waypoints* way) {
  for (int i = 0; i < config.shortcuts && way->size() > 2; ++i) {
    // Every other time between waypoints, so that a needless one goes for good.
    double low = rng->Uniform(0.0, 1.0);
    double high = rng->Uniform(0.0, 1.0);
    if (low > high) std::swap(low, high);
    if (i % 2 == 0) {
      const auto pieces = static_cast<double>(way->size() - 1);
      low = std::floor(low * pieces) / pieces;
      high = std::ceil(high * pieces) / pieces;
    }
    const Place from = PlaceOn(*way, low);
    const Place to = PlaceOn(*way, high);
    if (from.piece == to.piece) continue;
    Waypoints shorter(way->begin(), way->begin() + static_cast<std::ptrdiff_t>(from.piece) + 1);
    shorter.push_back(from.q);
    shorter.push_back(to.q);
    shorter.insert(shorter.end(), way->begin() + static_cast<std::ptrdiff_t>(to.piece) + 1,
                   way->end());
    const auto same = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return (a - b).cwiseAbs().maxCoeff() < 1e-9;
    };
    shorter.erase(std::unique(shorter.begin(), shorter.end(), same), shorter.end());
    if (SecondsAlong(shorter, joints) >= SecondsAlong(*way, joints)) continue;
    if (StraightIsFree(collision, from.q, to.q, config.step_m)) *way = std::move(shorter);
  }
}

void CheckAngles(const Eigen::VectorXd& q, const char* which, int size) {
  if (q.size() == size && q.allFinite()) return;
  Throw<InvalidArgument>("motion: the {} has not {} finite joint angles", which, size);
}

/// Which joint of `q` is beyond its limits, in words; empty when none is.
std::string BeyondLimits(const Eigen::VectorXd& q, const kinematics::Chain& chain) {
  for (int i = 0; i < chain.size(); ++i) {
    const kinematics::Joint& joint = chain.joint(i);
    if (q[i] >= joint.lower && q[i] <= joint.upper) continue;
    return fmt::format("joint '{}' at {:.2f} deg; its limits are {:.2f} to {:.2f} deg", joint.name,
                       q[i] * kDegrees, joint.lower * kDegrees, joint.upper * kDegrees);
  }
  return "";
}

PlannedMotion Refused(MotionOutcome outcome, std::string reason) {
  return {outcome, {}, std::move(reason)};
}

}  // namespace

void MotionConfig::Validate() const {
  CheckRange(iterations, 1, 1e6, "iterations");
  CheckRange(range, 0.01, 10.0, "range");
  CheckRange(step_m, 0.001, 0.5, "step_m");
  CheckRange(shortcuts, 0, 1e5, "shortcuts");
  CheckRange(speed_share, 0.01, 1.0, "speed_share");
}

bool StraightIsFree(const ArmCollision& collision, const Eigen::VectorXd& a,
                    const Eigen::VectorXd& b, double step_m) {
  const std::vector<double> radii = MotionRadii(collision.chain());
  double way = 0.0;  // of any point of the arm, at most
  for (int i = 0; i < a.size(); ++i) way += std::abs(b[i] - a[i]) * radii[i];
  const int steps = std::max(1, static_cast<int>(std::ceil(way / step_m)));
  // Ends first, then ever finer between them: what is in the way is found sooner.
  if (!collision.Free(b) || !collision.Free(a)) return false;
  int stride = 1;
  while (stride < steps) stride *= 2;
  for (; stride > 1; stride /= 2) {
    for (int i = stride / 2; i < steps; i += stride) {
      const double share = static_cast<double>(i) / steps;
      if (!collision.Free((1.0 - share) * a + share * b)) return false;
    }
  }
  return true;
}

PlannedMotion PlanMotion(const ArmCollision& collision, const std::vector<hal::JointInfo>& joints,
                         const Eigen::VectorXd& start, const Eigen::VectorXd& goal,
                         std::uint64_t seed, const MotionConfig& config) {
  config.Validate();
  const kinematics::Chain& chain = collision.chain();
  const double least =
      std::min(collision.config().clearance_m, collision.config().self_clearance_m);
  if (config.step_m > 2.0 * least) {
    Throw<ConfigError>(
        "step_m = {} must be at most twice the least clearance, {} m, or something could be passed "
        "through",
        config.step_m, least);
  }
  if (static_cast<int>(joints.size()) != chain.size()) {
    Throw<InvalidArgument>("motion: {} joints for a chain of {}", joints.size(), chain.size());
  }
  CheckAngles(start, "start", chain.size());
  CheckAngles(goal, "goal", chain.size());
  for (const auto& [q, which] : {std::pair{&start, "start"}, std::pair{&goal, "goal"}}) {
    const std::string beyond = BeyondLimits(*q, chain);
    if (!beyond.empty()) {
      return Refused(MotionOutcome::kOutOfLimits, fmt::format("the {} has {}", which, beyond));
    }
  }
  if (const auto touch = collision.Touches(start)) {
    return Refused(MotionOutcome::kStartInCollision,
                   fmt::format("the arm is in collision where it is: {}", *touch));
  }
  if (const auto touch = collision.Touches(goal)) {
    return Refused(MotionOutcome::kGoalInCollision,
                   fmt::format("the goal is in collision: {}", *touch));
  }
  const std::vector<hal::JointInfo> gentle = Gently(joints, config.speed_share);
  Rng rng(ForkSeed(seed, "motion"));
  Waypoints way{start, goal};
  if (!StraightIsFree(collision, start, goal, config.step_m)) {
    way = SearchWay(collision, start, goal, &rng, config);
    if (way.empty()) {
      return Refused(MotionOutcome::kNoWay,
                     fmt::format("no way found in {} iterations", config.iterations));
    }
    Shorten(collision, gentle, &rng, config, &way);
  }
  return {MotionOutcome::kFound, StopAndGo(way, gentle), ""};
}

}  // namespace secondlook::planning
