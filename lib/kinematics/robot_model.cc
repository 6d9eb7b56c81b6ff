#include "lib/kinematics/robot_model.h"

#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include "lib/common/error.h"
#include "lib/common/files.h"

namespace secondlook::kinematics {
namespace {

/// Keeps what urdfdom says instead of returning it.
class ErrorCatcher : public console_bridge::OutputHandler {
 public:
  ErrorCatcher() { console_bridge::useOutputHandler(this); }
  ~ErrorCatcher() override { console_bridge::restorePreviousOutputHandler(); }

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    text_ += (text_.empty() ? "" : "; ") + text;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

urdf::ModelInterfaceSharedPtr Parse(const std::string& text, const std::string& source) {
  static std::mutex one_at_a_time;  // the output handler is the process's
  const std::lock_guard lock(one_at_a_time);
  const ErrorCatcher errors;
  urdf::ModelInterfaceSharedPtr tree = urdf::parseURDF(text);
  if (!tree) {
    Throw<ConfigError>("{}: is no usable URDF: {}", source,
                       errors.text().empty() ? "it is no XML" : errors.text());
  }
  return tree;
}

Pose ToPose(const urdf::Pose& pose) {
  Pose X = Pose::Identity();
  X.translation() << pose.position.x, pose.position.y, pose.position.z;
  X.linear() =
      Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z)
          .normalized()
          .toRotationMatrix();
  return X;
}

void RequirePositive(double value, const char* what, const std::string& link,
                     const std::string& source) {
  if (value > 0.0 && std::isfinite(value)) return;
  Throw<ConfigError>("{}: link '{}' has a body with a {} of {} m; it must be positive", source,
                     link, what, value);
}

geometry::Shape ToShape(const urdf::Geometry& geometry, const std::string& link,
                        const std::string& source) {
  if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
    for (const double edge : {box->dim.x, box->dim.y, box->dim.z}) {
      RequirePositive(edge, "edge", link, source);
    }
    return geometry::Box{{box->dim.x, box->dim.y, box->dim.z}};
  }
  if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
    RequirePositive(cylinder->radius, "radius", link, source);
    RequirePositive(cylinder->length, "length", link, source);
    return geometry::Cylinder{cylinder->radius, cylinder->length};
  }
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
    RequirePositive(sphere->radius, "radius", link, source);
    return geometry::Sphere{sphere->radius};
  }
  Throw<ConfigError>(
      "{}: link '{}' has a mesh for a body; describe it by boxes, cylinders and spheres", source,
      link);
}

void ReadRevolute(const urdf::Joint& joint, const std::string& source, Joint* result) {
  const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (!axis.allFinite() || axis.norm() < 1e-9) {
    Throw<ConfigError>("{}: the axis ({}, {}, {}) of joint '{}' has no direction", source, axis.x(),
                       axis.y(), axis.z(), joint.name);
  }
  if (!joint.limits) {
    Throw<ConfigError>("{}: joint '{}' has no limits; give its lower, upper and velocity", source,
                       joint.name);
  }
  const urdf::JointLimits& limits = *joint.limits;
  if (!std::isfinite(limits.lower) || !std::isfinite(limits.upper) ||
      !(limits.lower < limits.upper)) {
    Throw<ConfigError>(
        "{}: the limits of joint '{}' contradict each other: lower {} rad must be less than upper "
        "{} rad",
        source, joint.name, limits.lower, limits.upper);
  }
  if (!(limits.velocity > 0.0) || !std::isfinite(limits.velocity)) {
    Throw<ConfigError>("{}: the velocity limit of joint '{}' is {} rad/s; it must be positive",
                       source, joint.name, limits.velocity);
  }
  result->turns = true;
  result->axis_L = axis.normalized();
  result->lower = limits.lower;
  result->upper = limits.upper;
  result->speed = limits.velocity;
}

Joint ToJoint(const urdf::Joint& joint, const std::string& source) {
  Joint result;
  result.name = joint.name;
  result.X_PL = ToPose(joint.parent_to_joint_origin_transform);
  if (!IsValid(result.X_PL)) {
    Throw<ConfigError>("{}: the origin of joint '{}' is no rigid transform", source, joint.name);
  }
  if (joint.type == urdf::Joint::REVOLUTE) {
    ReadRevolute(joint, source, &result);
  } else if (joint.type == urdf::Joint::CONTINUOUS) {
    Throw<ConfigError>("{}: joint '{}' is continuous, without limits; make it revolute", source,
                       joint.name);
  } else if (joint.type != urdf::Joint::FIXED) {
    Throw<ConfigError>("{}: joint '{}' is neither revolute nor fixed", source, joint.name);
  }
  return result;
}

/// A link with two parents closes a loop, which urdfdom takes for a tree.
void RequireTree(const urdf::ModelInterface& tree, const std::string& source) {
  std::map<std::string, std::string> joint_of;
  for (const auto& [name, joint] : tree.joints_) {
    const auto [other, first] = joint_of.emplace(joint->child_link_name, name);
    if (first) continue;
    Throw<ConfigError>("{}: link '{}' is the child of joint '{}' and of joint '{}': a loop", source,
                       joint->child_link_name, other->second, name);
  }
}

class TreeReader {
 public:
  TreeReader(const std::string& source, RobotModel* model) : source_(source), model_(*model) {}

  void Add(const urdf::Link& link, int parent) {
    Link added;
    added.name = link.name;
    added.parent = parent;
    if (parent >= 0) added.joint = ToJoint(*link.parent_joint, source_);
    for (const urdf::CollisionSharedPtr& body : link.collision_array) {
      if (!body->geometry) continue;
      added.body.push_back({ToShape(*body->geometry, link.name, source_), ToPose(body->origin)});
      if (!IsValid(added.body.back().X_AS)) {
        Throw<ConfigError>("{}: the origin of a body of link '{}' is no rigid transform", source_,
                           link.name);
      }
    }
    const int index = static_cast<int>(model_.links.size());
    model_.links.push_back(std::move(added));
    for (const urdf::LinkSharedPtr& child : link.child_links) Add(*child, index);
  }

 private:
  const std::string& source_;
  RobotModel& model_;
};

}  // namespace

int RobotModel::IndexOf(const std::string& link) const {
  std::string known;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == link) return static_cast<int>(i);
    known += (i == 0 ? "'" : ", '") + links[i].name + "'";
  }
  Throw<ConfigError>("robot '{}' has no link '{}'; its links are {}", name, link, known);
}

std::vector<Pose> LinkPoses(const RobotModel& model, const std::vector<double>& angles) {
  std::vector<Pose> X_RL(model.links.size(), Pose::Identity());
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const Link& link = model.links[i];
    X_RL[i] = X_RL[link.parent] * link.joint.X_PL;
    if (link.joint.turns) X_RL[i].rotate(Eigen::AngleAxisd(angles[i], link.joint.axis_L));
  }
  return X_RL;
}

RobotModel ParseUrdf(const std::string& text, const std::string& source) {
  const urdf::ModelInterfaceSharedPtr tree = Parse(text, source);
  RequireTree(*tree, source);
  RobotModel model;
  model.name = tree->getName();
  model.urdf = text;
  TreeReader(source, &model).Add(*tree->getRoot(), -1);
  if (model.links.size() < tree->links_.size()) {
    for (const auto& [name, link] : tree->links_) {
      bool found = false;
      for (const Link& reached : model.links) found |= reached.name == name;
      if (found) continue;
      Throw<ConfigError>("{}: link '{}' does not hang on the root '{}': it is in a loop", source,
                         name, model.links.front().name);
    }
  }
  return model;
}

RobotModel LoadUrdf(const std::filesystem::path& file) {
  return ParseUrdf(ReadFile(file), file.string());
}

}  // namespace secondlook::kinematics
