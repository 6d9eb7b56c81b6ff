#include "sim/standing_room.h"

#include "lib/common/error.h"
#include "sim/base_drive.h"
#include "sim/fixtures.h"
#include "sim/surroundings.h"

namespace secondlook::sim {
namespace {

using Eigen::Vector2d;

void RequireRoomFor(const std::string& who, const Vector2d& p_W, double radius,
                    const std::vector<Footprint>& footprints) {
  for (const Footprint& footprint : footprints) {
    if (NearestOf(footprint, p_W, p_W).distance >= radius) continue;
    Throw<ConfigError>("{} of {:.2f} m radius starts at [{}, {}], which is within '{}'; move one",
                       who, radius, p_W.x(), p_W.y(), footprint.name);
  }
}

}  // namespace

void RequireStandingRoom(const Scene& scene, const std::vector<PlacedObject>& objects) {
  const hal::BaseInfo& base = BaseDrive::Info();
  const Vector2d robot_W = scene.robot.position;
  if (((robot_W.cwiseAbs() - scene.floor.size / 2.0).array() > 0.0).any()) {
    Throw<ConfigError>("the robot starts at [{}, {}], which is off the floor of {} x {} m",
                       robot_W.x(), robot_W.y(), scene.floor.size.x(), scene.floor.size.y());
  }
  RequireRoomFor("the robot", robot_W, base.radius,
                 MakeFootprints(MakeFixtures(scene, objects, base.height)));
  for (const MovingObstacle& obstacle : scene.moving_obstacles) {
    const Vector2d p_W = obstacle.waypoints.front();
    RequireRoomFor("'" + obstacle.name + "'", p_W, obstacle.radius,
                   MakeFootprints(MakeFixtures(scene, objects, obstacle.height)));
    if ((p_W - robot_W).norm() >= base.radius + obstacle.radius) continue;
    Throw<ConfigError>("'{}' starts at [{}, {}], which is within the robot; move one",
                       obstacle.name, p_W.x(), p_W.y());
  }
}

}  // namespace secondlook::sim
