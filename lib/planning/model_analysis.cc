#include "lib/planning/model_analysis.h"

#include <cmath>

#include "lib/geometry/point_image.h"

namespace secondlook::planning {
namespace {

/// True when the camera would measure something else on the two models.
bool Differs(const PosedModel& a, const geometry::RayHit& hit_a, const PosedModel& b,
             const geometry::RayHit& hit_b, const AspectGraphConfig& config) {
  if (hit_a.triangle < 0 || hit_b.triangle < 0) return true;  // one of them lets the ray by
  const double sigma = geometry::DepthSigma(0.5 * (hit_a.distance + hit_b.distance));
  if (std::abs(hit_a.distance - hit_b.distance) > config.depth_sigmas * sigma) return true;
  const Eigen::Vector3f color_a = geometry::ColorAt(*a.mesh, hit_a.triangle, hit_a.weights);
  const Eigen::Vector3f color_b = geometry::ColorAt(*b.mesh, hit_b.triangle, hit_b.weights);
  return (color_a - color_b).cwiseAbs().maxCoeff() > config.color_difference;
}

}  // namespace

std::vector<geometry::RayHit> CastAt(const PosedModel& model, const Pose& X_WC,
                                     const std::vector<BoxRay>& rays) {
  const Pose X_MW = model.X_WM.inverse();
  const Eigen::Vector3f p_MC = (X_MW * X_WC.translation()).cast<float>();
  std::vector<geometry::Ray> rays_M;
  rays_M.reserve(rays.size());
  for (const BoxRay& ray : rays) {
    rays_M.push_back({p_MC, (X_MW.linear() * ray.direction_W).cast<float>()});
  }
  return model.caster->Cast(rays_M);
}

ModelVisibility Visibility(const PosedModel& model, const geometry::CameraModel& camera,
                           const std::vector<BoxRay>& rays,
                           const std::vector<geometry::RayHit>& hits) {
  ModelVisibility visibility;
  const Eigen::Matrix3d R_MW = model.X_WM.linear().transpose();
  int of_model = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].triangle < 0) continue;
    ++of_model;
    if (rays[i].stopped) continue;
    visibility.box_share += rays[i].chance;
    visibility.view_share += 1.0;
    // A pixel's patch of a surface at depth z: z^2 / (fx fy |n . direction|).
    const double slant = std::abs(hits[i].normal_M.cast<double>().dot(R_MW * rays[i].direction_W));
    const double z = hits[i].distance;
    if (slant > 1e-3) visibility.area += rays[i].chance * z * z / (camera.fx * camera.fy * slant);
  }
  if (of_model > 0) visibility.seen = visibility.box_share / of_model;
  if (!rays.empty()) visibility.box_share /= static_cast<double>(rays.size());
  visibility.view_share /= static_cast<double>(camera.width) * camera.height;
  return visibility;
}

double CompromiseScore(const std::vector<ModelVisibility>& models) {
  double score = 0.0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    score += models[i].view_share;
    for (std::size_t j = 0; j < i; ++j) {
      score -= std::abs(models[i].view_share - models[j].view_share);
    }
  }
  return score;
}

NewsRays DifferingRays(const PosedModel& a, const std::vector<geometry::RayHit>& hits_a,
                       const PosedModel& b, const std::vector<geometry::RayHit>& hits_b,
                       const std::vector<BoxRay>& rays, const AspectGraphConfig& config) {
  NewsRays differing;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits_a[i].triangle < 0 && hits_b[i].triangle < 0) continue;
    differing.Add(rays[i], !rays[i].stopped && Differs(a, hits_a[i], b, hits_b[i], config));
  }
  return differing;
}

NewsRays RaysTo(const std::vector<geometry::RayHit>* hits, const std::vector<BoxRay>& rays) {
  NewsRays seen;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits == nullptr || (*hits)[i].triangle >= 0) seen.Add(rays[i], true);
  }
  return seen;
}

}  // namespace secondlook::planning
