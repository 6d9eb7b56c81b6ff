#include "apps/modelling_config.h"

namespace secondlook::apps {
namespace {

void RequireShare(const char* name, double value) {
  if (value > 0.0 && value <= 1.0) return;
  Throw<ConfigError>("modelling.{} = {} must be a share: more than 0 and at most 1", name, value);
}

void RequireLength(const char* name, double value) {
  if (value > 0.0 && value <= 2.0) return;
  Throw<ConfigError>("modelling.{} = {} must be more than 0 and at most 2 m", name, value);
}

}  // namespace

ScanStrategy ParseScanStrategy(const std::string& text) {
  if (text == "new surface") return ScanStrategy::kNewSurface;
  if (text == "Kriegel") return ScanStrategy::kKriegel;
  if (text == "random") return ScanStrategy::kRandom;
  if (text == "fixed step") return ScanStrategy::kFixedStep;
  Throw<ConfigError>(
      "modelling.strategy = '{}'; it must be 'new surface', 'Kriegel', 'random' or 'fixed step'",
      text);
}

void ModellingConfig::Validate() const {
  ParseScanStrategy(strategy);
  surface.Validate();
  borders.Validate();
  gain.Validate();
  RequireShare("coverage", coverage);
  RequireShare("worthwhile", worthwhile);
  RequireShare("least_coverage", least_coverage);
  RequireLength("largest_m", largest_m);
  RequireLength("around_m", around_m);
  RequireLength("stands_m", stands_m);
  RequireLength("detail_m", detail_m);
  RequireLength("view_m", view_m);
  if (!(view_rad > 0.0 && view_rad <= 0.5)) {
    Throw<ConfigError>("modelling.view_rad = {} must be more than 0 and at most 0.5", view_rad);
  }
  if (scans < 1) Throw<ConfigError>("modelling.scans = {} must be at least 1", scans);
  if (recognition_failures < 1) {
    Throw<ConfigError>("modelling.recognition_failures = {} must be at least 1",
                       recognition_failures);
  }
}

}  // namespace secondlook::apps
