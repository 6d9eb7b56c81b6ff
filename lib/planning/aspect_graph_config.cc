#include "lib/planning/aspect_graph_config.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

constexpr std::array<std::pair<const char*, LookStrategy>, 5> kStrategies = {
    {{"expected loss", LookStrategy::kExpectedLoss},
     {"McGreavy", LookStrategy::kMcGreavy},
     {"nearest", LookStrategy::kNearest},
     {"random", LookStrategy::kRandom},
     {"fixed step", LookStrategy::kFixedStep}}};

}  // namespace

LookStrategy ParseLookStrategy(const std::string& text) {
  std::string expected;
  for (const auto& [name, strategy] : kStrategies) {
    if (text == name) return strategy;
    expected += fmt::format("{}'{}'", expected.empty() ? "" : ", ", name);
  }
  Throw<ConfigError>("strategy '{}' is none of {}", text, expected);
}

void AspectGraphConfig::Validate() const {
  ParseLookStrategy(strategy);
  CheckRange(ray_columns, 8, 4096, "ray_columns");
  CheckRange(region_ray_columns, 8, 4096, "region_ray_columns");
  CheckRange(box_margin_m, 0.0, 1.0, "box_margin_m");
  CheckRange(unknown_m, 0.0, 10.0, "unknown_m");
  CheckRange(unknown_survival, 0.0, 1.0, "unknown_survival");
  CheckRange(min_visibility, 0.0, 1.0, "min_visibility");
  CheckRange(same_view_deg, 0.0, 179.0, "same_view_deg");
  CheckRange(new_view_deg, same_view_deg + 1.0, 180.0, "new_view_deg");
  CheckRange(new_view_unknown_deg, same_view_deg + 1.0, 180.0, "new_view_unknown_deg");
  CheckRange(same_view_novelty, 0.0, 1.0, "same_view_novelty");
  CheckRange(look_seconds, 0.01, 3600.0, "look_seconds");
  CheckRange(depth_sigmas, 0.0, 100.0, "depth_sigmas");
  CheckRange(color_difference, 0.0, 1.0, "color_difference");
  loss.Validate();
  look_ahead.Validate();
  CheckRange(evidence, 0.0, 1e6, "evidence");
  CheckRange(unlike, 0.0, 1.0, "unlike");
  CheckRange(few_px, 0.0, 1e9, "few_px");
  CheckRange(ahead_speed, 0.01, 100.0, "ahead_speed");
  CheckRange(fixed_step_deg, -360.0, 360.0, "fixed_step_deg");
}

}  // namespace secondlook::planning
