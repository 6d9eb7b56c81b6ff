#pragma once

#include <string>
#include <vector>

#include "apps/experiments/experiment.h"
#include "apps/experiments/nbv_sets.h"

namespace secondlook::apps {

/// The figures of `experiment nbv-dataset` (docs/cli.md), bootstrapped over sets. Plots go to the
/// folder `report`, if any.
std::vector<Row> SummariseNbv(const std::vector<NbvSet>& sets, const NbvClassifier& classifier,
                              const std::string& report = "");

}  // namespace secondlook::apps
