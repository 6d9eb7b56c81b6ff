#include "lib/planning/aspect_target.h"

#include <cmath>

#include "lib/common/error.h"

namespace secondlook::planning {

void RequireValid(const AspectTarget& target) {
  const Eigen::AlignedBox3d& box_W = target.box_W;
  if (!box_W.min().allFinite() || !box_W.max().allFinite() || box_W.isEmpty() ||
      !(box_W.sizes().minCoeff() >= 0.001)) {
    Throw<InvalidArgument>(
        "aspect graph: the box of target {} from ({}, {}, {}) to ({}, {}, {}) m must be finite and "
        "at least 1 mm wide",
        target.id, box_W.min().x(), box_W.min().y(), box_W.min().z(), box_W.max().x(),
        box_W.max().y(), box_W.max().z());
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < target.hypotheses.size(); ++i) {
    const PosedModel& model = target.hypotheses[i];
    if (!IsValid(model.X_WM)) {
      Throw<InvalidArgument>(
          "aspect graph: X_WM of hypothesis {} of target {} is not finite and "
          "rigid",
          i, target.id);
    }
    if (model.mesh == nullptr || model.caster == nullptr) {
      Throw<InvalidArgument>("aspect graph: hypothesis {} of target {} has no mesh", i, target.id);
    }
    if (!(model.belief >= 0.0 && model.needed >= 0.0 && model.needed < 1.0)) {
      Throw<InvalidArgument>(
          "aspect graph: hypothesis {} of target {} with belief {}, of which {} is needed; they "
          "must lie in 0..1",
          i, target.id, model.belief, model.needed);
    }
    sum += model.belief;
  }
  if (!(sum <= 1.0 + 1e-6 && target.none >= 0.0 && target.none <= 1.0)) {
    Throw<InvalidArgument>(
        "aspect graph: the beliefs in the hypotheses of target {} sum to {}, and in none to {}; at "
        "most 1 each",
        target.id, sum, target.none);
  }
  for (const Eigen::Vector3d& seen_W : target.seen_from_W) {
    if (!(std::abs(seen_W.norm() - 1.0) < 1e-6)) {
      Throw<InvalidArgument>(
          "aspect graph: the direction ({}, {}, {}) from which target {} was "
          "seen is no unit vector",
          seen_W.x(), seen_W.y(), seen_W.z(), target.id);
    }
  }
}

}  // namespace secondlook::planning
