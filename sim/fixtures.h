#pragma once

#include <string>
#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "sim/footprint.h"
#include "sim/scene.h"

namespace secondlook::sim {

// What the pixels of Render::id show, besides the objects, whose id is their index +
// kFirstObjectId.
inline constexpr int kFirstObjectId = 1;
inline constexpr int kTableId = 60001;
inline constexpr int kFloorId = 60002;
inline constexpr int kWallId = 60003;
inline constexpr int kBoxId = 60004;
inline constexpr int kMovingObstacleId = 60005;
inline constexpr int kOwnBodyId = 60006;

/// A thing of the scene that never moves.
struct Fixture {
  std::string name;
  Pose X_WM{Pose::Identity()};
  geometry::Mesh mesh;
  int id{};           ///< Render::id of its pixels.
  bool in_the_way{};  ///< True when the base can run into it.
};

/// Floor, walls, table and boxes of `scene`, and its `objects`, in this order. Things whose lowest
/// point is above `robot_height` [m] are not in the way of the base.
std::vector<Fixture> MakeFixtures(const Scene& scene, const std::vector<PlacedObject>& objects,
                                  double robot_height);

/// The footprints of those that are in the way.
std::vector<Footprint> MakeFootprints(const std::vector<Fixture>& fixtures);

}  // namespace secondlook::sim
