#include "apps/experiments/clutter.h"

#include <algorithm>
#include <optional>

#include "apps/experiments/free_camera.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/single_view.h"
#include "sim/fixtures.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

constexpr int kMostViews = 40;

/// The cluster that shows most pixels of `id`.
world::Cluster ClusterOf(const std::vector<world::Cluster>& clusters, const cv::Mat& ids, int id) {
  world::Cluster best;
  std::ptrdiff_t most = 0;
  for (const world::Cluster& cluster : clusters) {
    const auto count = std::count_if(cluster.pixels.begin(), cluster.pixels.end(), [&](int pixel) {
      return ids.at<std::uint16_t>(pixel / ids.cols, pixel % ids.cols) == id;
    });
    if (count <= most) continue;
    most = count;
    best = cluster;
  }
  return best;
}

}  // namespace

ClutteredThing DrawClutteredThing(const std::vector<sim::SceneObject>& things, std::uint64_t seed) {
  Rng rng(ForkSeed(seed, "clutter"));
  const sim::Scene scene = DrawCrowdedTable(things, &rng);
  FreeCamera camera(scene, seed);
  const std::vector<sim::PlacedObject>& placed = camera.world().objects();
  const int index = rng.Index(static_cast<int>(placed.size()));
  const sim::PlacedObject& thing = placed[index];
  const Vector3d target = thing.X_WM * geometry::Bounds(thing.mesh).center();
  Photo photo;
  double visible = 0.0;
  for (int i = 0; i < kMostViews && visible <= 0.5; ++i) {
    photo = camera.Take(DrawViewOf(target, &rng));
    visible = camera.VisibleShares(photo)[index];
  }
  ClutteredThing result;
  result.name = thing.name;
  result.X_CM = photo.X_WC.inverse() * thing.X_WM;
  result.visible = visible;
  const geometry::CameraModel& model = camera.info().model;
  const std::optional<CutPhoto> cut = Cut(photo, model);
  if (!cut) return result;
  result.cluster = ClusterOf(cut->clusters, photo.id, sim::kFirstObjectId + index);
  result.view = perception::MakeView(photo.frame.color, photo.frame.depth, model, cut->view.plane_C,
                                     {result.cluster});
  return result;
}

}  // namespace secondlook::apps
