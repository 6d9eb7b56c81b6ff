#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/experiments/experiment.h"
#include "apps/mission.h"
#include "lib/perception/appearance/classifier.h"
#include "lib/world/object_database.h"
#include "sim/sim_robot.h"

namespace secondlook::apps {

/// A way to go about a mission. Of several, the one that is compared with the others comes last.
struct Variant {
  std::string name;
  MissionConfig config;
  /// Makes what has the last word on its looks; none: nothing has.
  std::function<LookChooser(const Mission& mission)> chooser{};
};

/// What the missions of an experiment have in common. What is pointed to must outlive it.
struct CourseSetup {
  const world::ObjectDatabase* database{};
  world::Budget budget;  ///< A mission that leaves something open counts with all of it.
  sim::SimConfig robot{};
  const perception::Classifier* classifier{};  ///< None: things are known by shape alone.
};

/// Runs a mission in `scene`, all its errors drawn from `seed`: the course of docs/cli.md,
/// "search".
nlohmann::ordered_json RunCourse(const sim::Scene& scene, const Variant& variant,
                                 const CourseSetup& setup, std::uint64_t seed);

/// A figure of a course.
using CourseMeasure = std::function<double(const nlohmann::ordered_json& course)>;

/// The number at `key`.
CourseMeasure NumberAt(const char* key);

/// What the task loses by the truth, `before` as long as nothing has been seen.
struct CourseLoss {
  double before{};

  double AfterSeconds(const nlohmann::ordered_json& course, double seconds) const;
  double AfterMetres(const nlohmann::ordered_json& course, double metres) const;
  /// The mean from the start until `seconds`.
  double Mean(const nlohmann::ordered_json& course, double seconds) const;
};

/// Rows of the mean by variant, and of how much it is less with the last than with each other. Of
/// each trial the courses are in `courses`, by name.
void AddMeans(const std::string& metric, const std::vector<nlohmann::ordered_json>& trials,
              const std::vector<Variant>& variants, const CourseMeasure& measure,
              std::vector<Row>* rows);

/// Those of looks, robot time, way, and how the missions end.
void AddOutcomes(const std::vector<nlohmann::ordered_json>& trials,
                 const std::vector<Variant>& variants, std::vector<Row>* rows);

}  // namespace secondlook::apps
