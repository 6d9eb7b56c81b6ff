#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/ray_caster.h"

namespace secondlook::planning {

/// A model that may stand at a pose. What the pointers show must outlive the call it is for.
struct PosedModel {
  const geometry::Mesh* mesh{};         ///< Not null; for the colours.
  const geometry::RayCaster* caster{};  ///< Not null; of the same mesh.
  Pose X_WM{Pose::Identity()};
  double belief{0.5};  ///< Its probability; those of a target sum to at most 1.
  double needed{0.9};  ///< The task decides for it from this probability on, in [0, 1).
};

/// What the next look is for.
struct AspectTarget {
  int id{-1};  ///< Object id, as the looks carry it; -1: space where one could stand unseen.
  Eigen::AlignedBox3d box_W;           ///< Around the candidate: its hypotheses and its points.
  std::vector<PosedModel> hypotheses;  ///< Empty: no model fits.
  double none{0.5};  ///< Probability that nothing that is known fits. Of hypotheses it is the rest.
  /// Unit vectors from the target to the cameras of the views taken, oldest first, none of which
  /// has settled it.
  std::vector<Eigen::Vector3d> seen_from_W;
};

/// @throws InvalidArgument for a box that is empty, not finite or smaller than 1 mm, a pose or
/// direction that is not valid, a null mesh, or beliefs that are no probabilities.
void RequireValid(const AspectTarget& target);

}  // namespace secondlook::planning
