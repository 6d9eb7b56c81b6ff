#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "sim/scene_renderer.h"
#include "sim/world.h"

namespace secondlook::sim {

// For tests, bench and experiments alone: the mission never sees this file.

/// How much of an object a frame shows.
struct Visibility {
  int visible_pixels{};     ///< That show it.
  int unoccluded_pixels{};  ///< That would if nothing else were there.
};

/// What is truly there, for the judge of a mission.
class GroundTruth {
 public:
  /// `world` must outlive this.
  explicit GroundTruth(const World& world) : world_(world) {}

  /// Name, role, pose X_WM and mesh of each object, in the order of the scene.
  const std::vector<PlacedObject>& objects() const { return world_.objects(); }

  /// The true camera poses X_WC of the frames grabbed so far, in their order.
  const std::vector<TrueView>& views() const { return world_.views(); }

  /// The view of frame `sequence`. @throws InvalidArgument when no such frame was grabbed.
  const TrueView& ViewOf(std::uint64_t sequence) const;

  /// The clean picture of frame `sequence`, through `model`.
  Render CleanFrame(std::uint64_t sequence, const geometry::CameraModel& model);

  /// How much frame `sequence` shows of each object, through `model`. It renders each one alone.
  std::vector<Visibility> VisibilityIn(std::uint64_t sequence, const geometry::CameraModel& model);

  const std::vector<Collision>& collisions() const { return world_.collisions(); }
  double metres_driven() const { return world_.base().metres(); }

 private:
  SceneRenderer& RendererFor(const geometry::CameraModel& model);

  const World& world_;
  geometry::CameraModel model_;
  std::unique_ptr<SceneRenderer> renderer_;
};

}  // namespace secondlook::sim
