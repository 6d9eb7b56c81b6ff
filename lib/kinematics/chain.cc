#include "lib/kinematics/chain.h"

#include <algorithm>
#include <utility>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "lib/common/error.h"

namespace secondlook::kinematics {
namespace {

KDL::Vector ToVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame ToFrame(const Pose& X) {
  const Eigen::Matrix3d R = X.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                        R(2, 2)),
          ToVector(X.translation())};
}

KDL::JntArray ToJoints(const Eigen::VectorXd& q) {
  KDL::JntArray joints(static_cast<unsigned>(q.size()));
  joints.data = q;
  return joints;
}

Pose FromKdl(const KDL::Frame& frame) {
  Pose X = Pose::Identity();
  for (int i = 0; i < 3; ++i) {
    X.translation()[i] = frame.p[i];
    for (int j = 0; j < 3; ++j) X.linear()(i, j) = frame.M(i, j);
  }
  return X;
}

}  // namespace

struct Chain::Parts {
  RobotModel model;
  int tip{};                    // index of the link
  std::vector<int> links;       // that the joints move, base to tip
  std::vector<double> resting;  // of all joints, those of the chain 0
  KDL::Chain kdl;
};

Chain::Chain(RobotModel model, const std::string& tip) {
  auto parts = std::make_shared<Parts>();
  parts->model = std::move(model);
  const std::vector<Link>& links = parts->model.links;
  std::vector<int> way;
  parts->tip = parts->model.IndexOf(tip);
  for (int i = parts->tip; i > 0; i = links[i].parent) way.push_back(i);
  std::reverse(way.begin(), way.end());
  for (const int i : way) {
    const Joint& joint = links[i].joint;
    if (!joint.turns) {
      parts->kdl.addSegment(
          KDL::Segment(links[i].name, KDL::Joint(KDL::Joint::Fixed), ToFrame(joint.X_PL)));
      continue;
    }
    parts->links.push_back(i);
    // KDL turns about an axis given in the parent, and then goes on to the link's frame.
    parts->kdl.addSegment(
        KDL::Segment(links[i].name,
                     KDL::Joint(joint.name, ToVector(joint.X_PL.translation()),
                                ToVector(joint.X_PL.linear() * joint.axis_L), KDL::Joint::RotAxis),
                     ToFrame(joint.X_PL)));
  }
  if (parts->links.empty()) {
    Throw<ConfigError>("robot '{}': no joint between its root '{}' and the tip '{}'",
                       parts->model.name, links.front().name, tip);
  }
  for (const Link& link : links) {
    parts->resting.push_back(link.joint.turns ? std::clamp(0.0, link.joint.lower, link.joint.upper)
                                              : 0.0);
  }
  parts_ = std::move(parts);
}

Chain::~Chain() = default;

const RobotModel& Chain::model() const { return parts_->model; }

const Link& Chain::tip() const { return parts_->model.links[parts_->tip]; }

int Chain::size() const { return static_cast<int>(parts_->links.size()); }

int Chain::link_of(int i) const { return parts_->links[i]; }

bool Chain::Moves(int link) const {
  while (link > 0 && link != link_of(0)) link = model().links[link].parent;
  return link > 0;
}

const Joint& Chain::joint(int i) const { return parts_->model.links[parts_->links[i]].joint; }

bool Chain::WithinLimits(const Eigen::VectorXd& q) const {
  for (int i = 0; i < size(); ++i) {
    if (!(q[i] >= joint(i).lower && q[i] <= joint(i).upper)) return false;
  }
  return true;
}

Pose Chain::TipPose(const Eigen::VectorXd& q) const {
  KDL::Frame tip;
  KDL::ChainFkSolverPos_recursive(parts_->kdl).JntToCart(ToJoints(q), tip);
  return FromKdl(tip);
}

Eigen::Matrix<double, 6, Eigen::Dynamic> Chain::Jacobian(const Eigen::VectorXd& q) const {
  KDL::Jacobian jacobian(static_cast<unsigned>(size()));
  KDL::ChainJntToJacSolver(parts_->kdl).JntToJac(ToJoints(q), jacobian);
  return jacobian.data;
}

std::vector<Pose> Chain::LinkPoses(const Eigen::VectorXd& q) const {
  std::vector<double> angles = parts_->resting;
  for (int i = 0; i < size(); ++i) angles[parts_->links[i]] = q[i];
  return kinematics::LinkPoses(parts_->model, angles);
}

std::vector<geometry::PlacedShape> Chain::Body(const Eigen::VectorXd& q) const {
  const std::vector<Pose> X_BL = LinkPoses(q);
  std::vector<geometry::PlacedShape> body;
  for (std::size_t i = 0; i < X_BL.size(); ++i) {
    for (const geometry::PlacedShape& part : parts_->model.links[i].body) {
      body.push_back({part.shape, X_BL[i] * part.X_AS});
    }
  }
  return body;
}

}  // namespace secondlook::kinematics
