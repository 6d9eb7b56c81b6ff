#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/experiments/experiment.h"
#include "apps/experiments/look_trial.h"
#include "lib/common/rng.h"

namespace secondlook::apps {

/// A look that does not settle the object rightly counts with this [s].
constexpr double kBudgetSeconds = 60.0;

/// Tries all looks and takes the best by the truth: what no chooser can beat.
constexpr const char* kOracle = "oracle";

/// Begins `trial` 1.4 to 2.2 m from the object and within `spread` [rad] of `azimuth` around it,
/// anew until the place is promising and what the first view finds is acceptable. False after 12
/// attempts.
bool BeginWhere(const std::function<bool(const Stance&)>& promising,
                const std::function<bool(const Finding&)>& acceptable, double azimuth,
                double spread, LookTrial* trial, Rng* rng);

/// Up to `looks` looks as `chooser` says, until the object is verified or called unknown:
/// `findings`, one a look, `stances`, and `seconds` of robot time: the budget unless that ends as
/// `trial` really is.
nlohmann::ordered_json Follow(const std::string& chooser, int looks, LookTrial* trial);

/// The course of one look from a `promising` place that `good` says is right, if any of all that
/// are possible is: those are tried that score best by ours, until one is.
nlohmann::ordered_json FollowOracle(const std::function<bool(const Stance&)>& promising,
                                    const std::function<bool(const Finding&)>& good,
                                    LookTrial* trial);

/// Those looks from the start of `trial` that are possible, whatever they would bring.
std::vector<world::Look> PossibleLooks(LookTrial* trial);

nlohmann::ordered_json ToJson(const Finding& finding);
/// [x, y, yaw, pan, tilt], in metres and radians.
nlohmann::ordered_json ToJson(const Stance& stance);
Stance StanceFrom(const nlohmann::ordered_json& json);

/// A figure of one course.
using Measure = std::function<double(const nlohmann::ordered_json& course)>;

/// The trials that found a start.
std::vector<nlohmann::ordered_json> Begun(const std::vector<nlohmann::ordered_json>& trials);

/// The course's last finding; null when no look was possible.
nlohmann::ordered_json LastFinding(const nlohmann::ordered_json& course);

/// For each chooser, and the oracle where there is one, the share of the begun trials in which
/// `holds` is not 0. Ours has the paper's figure, and the paper's method as its baseline.
void AddShares(const std::string& metric, const std::vector<nlohmann::ordered_json>& trials,
               std::optional<double> paper, const Measure& holds, std::vector<Row>* rows);

/// What ours lacks after the first look where it fails (Finding::lacks), as shares of the begun
/// trials.
void AddFailures(const std::vector<nlohmann::ordered_json>& trials, std::vector<Row>* rows);

/// Of the begun trials in which the oracle finds a look for which `holds`, the share in which the
/// paper's chooser and ours do.
void AddSharesWherePossible(const std::string& metric,
                            const std::vector<nlohmann::ordered_json>& trials, const Measure& holds,
                            std::vector<Row>* rows);

/// For each chooser the robot time of the begun trials, and by how much ours takes less than each.
void AddSeconds(const std::vector<nlohmann::ordered_json>& trials, std::vector<Row>* rows);

/// The share of the trials that found a start.
Row StartRow(const std::vector<nlohmann::ordered_json>& trials);

}  // namespace secondlook::apps
