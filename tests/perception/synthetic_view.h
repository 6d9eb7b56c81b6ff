#pragma once

#include <vector>

#include "lib/common/rng.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"
#include "lib/world/observation.h"

namespace secondlook::perception {

/// An upright letter L of blocks, 18 cm high: no symmetry. z up, base at z = 0, one colour a block.
world::ObjectModel MakeEll(const std::string& name, const Eigen::Vector3f& upright,
                           const Eigen::Vector3f& foot);

/// A box on z = 0 whose sides can be told apart by colour, except that all are `sides`.
world::ObjectModel MakeBoxModel(const std::string& name, const Eigen::Vector3d& size,
                                const Eigen::Vector3f& sides, const Eigen::Vector3f& front);

/// A thing in a drawn scene.
struct Placed {
  const RecognitionModel* model;
  Pose X_WM;
};

/// A picture of things on a table at z = 0 of W, and what segmentation would say of it.
struct SyntheticView {
  Pose X_WC;
  View view;
  std::vector<world::Cluster> clusters;  ///< One per thing that shows, in the order given.
};

/// Draws `things` with the project's own z-buffer from 1 m and 40 degrees above the table, with the
/// camera at `azimuth` [rad]; with `noise`, depth has the sensor's sigma and colour one of 4/255.
SyntheticView DrawView(const std::vector<Placed>& things, double azimuth, bool noise, Rng* rng);

/// Upright at (x, y), turned by `yaw` [rad].
Pose Upright(double x, double y, double yaw);

}  // namespace secondlook::perception
