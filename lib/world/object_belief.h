#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "lib/common/pose.h"
#include "lib/world/hypothesis.h"
#include "lib/world/mass_function.h"

namespace secondlook::world {

/// How settled an object is. Classified is what is known by its looks alone: a class that has no
/// model, and so no pose.
enum class ObjectState {
  kCandidate,
  kVerified,
  kClassified,
  kRejected,
  kUnknown,
  kModelling,
  kModelled
};

/// The name of a state as mission.json writes it, e.g. "verified".
const char* ToString(ObjectState state);

/// What one view says about one hypothesis.
struct ViewEvidence {
  int view{};             ///< Index into SceneBelief::views.
  Hypothesis hypothesis;  ///< Refined in that view: X_CM is in its camera.
};

/// That a certain model stands at a certain pose in the world, with what every view said of it.
struct PoseHypothesis {
  std::string model;
  Pose X_WM{Pose::Identity()};
  /// Of X_WM: (rotation vector [rad], translation [m]), in W.
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
  std::vector<ViewEvidence> evidence;  ///< One per view that could see it, in the order of views.
  double support{};                    ///< Of all views together, in [0, 1].
  double
      likely_free{};   ///< Share of its surface that lies where the map is likely free, in [0, 1].
  bool struck{};       ///< A view or the map contradicts it: out of the question.
  std::string reason;  ///< What struck it and why.

  /// The view that shows it best: of those that accept it, or of all when none does, the one with
  /// the most matching pixels. Null without evidence.
  const ViewEvidence* BestView() const;
};

/// That a view shows a thing.
struct Sighting {
  int view{};       ///< Index into SceneBelief::views.
  int detection{};  ///< Index into that observation's detections.
};

/// One thing on the table, and all that is known of it.
struct ObjectBelief {
  int id{};
  ObjectState state{ObjectState::kCandidate};
  std::string reason;                      ///< Why it is in that state, or what is still open.
  std::string history;                     ///< Where it was moved; empty: it was not.
  std::vector<Eigen::Vector3d> points_W;   ///< Its surface as seen so far, thinned [m].
  Eigen::AlignedBox3d extent_W;            ///< Of those points [m].
  MassFunction masses;                     ///< Over the classes, fused over the views.
  std::vector<PoseHypothesis> hypotheses;  ///< By falling support; struck ones last.
  std::vector<Sighting> sightings;         ///< In the order of the views, one each.
  int looks_taken{};                       ///< Looks that were taken for its sake.

  /// The hypothesis it stands for: the best that is not struck. Null when there is none.
  const PoseHypothesis* Best() const {
    return hypotheses.empty() || hypotheses.front().struck ? nullptr : &hypotheses.front();
  }

  /// The class with the largest mass, the first by name of equals; "" where none has any.
  std::string LeadingClass() const;

  /// True when no further look can be asked for: verified, classified, rejected, unknown or
  /// modelled.
  bool Settled() const {
    return state != ObjectState::kCandidate && state != ObjectState::kModelling;
  }
};

}  // namespace secondlook::world
