#include "apps/experiments/mission_courses.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "apps/experiments/judge.h"
#include "lib/planning/expected_loss.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

/// The net under a hang.
constexpr int kMaxSteps = 60;

/// What the task loses by how things truly are left.
double TrueLoss(const Mission& mission, const sim::World& world) {
  const planning::LossConfig loss;
  double sum = 0.0;
  for (const Verdict& verdict : Judge(mission, world)) {
    switch (verdict.kind) {
      case Verdict::Kind::kRight:
      case Verdict::Kind::kUnknownRight:
        break;
      case Verdict::Kind::kWrong:
        sum += loss.wrong;
        break;
      case Verdict::Kind::kMissed:
      case Verdict::Kind::kUnknownOpen:
        sum += loss.unsettled;
        break;
    }
  }
  return sum;
}

/// The loss that stands once `spent` seconds (of = 0) or metres (of = 1) are.
double LossAfter(const Json& course, double before, int of, double spent) {
  double loss = before;
  for (const Json& entry : course.at("loss")) {
    if (entry.at(of).get<double>() > spent) break;
    loss = entry.at(2);
  }
  return loss;
}

std::vector<double> ValuesOf(const std::vector<Json>& trials, const std::string& name,
                             const CourseMeasure& measure) {
  std::vector<double> values;
  for (const Json& trial : trials) values.push_back(measure(trial.at("courses").at(name)));
  return values;
}

}  // namespace

Json RunCourse(const sim::Scene& scene, const Variant& variant, const CourseSetup& setup,
               std::uint64_t seed) {
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(scene, setup.robot, seed);
  Publisher silent;
  world::Task task;
  task.budget = setup.budget;
  Mission mission(
      variant.config, task, *setup.database, simulated.calibration, seed, [] { return false; },
      &silent, &simulated.robot);
  if (simulated.hand) mission.KnowArm(*simulated.hand);
  if (setup.classifier != nullptr) mission.KnowClassifier(*setup.classifier);
  if (variant.chooser) mission.LetChoose(variant.chooser(mission));
  Json loss = Json::array();
  Progress progress = Progress::kMore;
  for (int step = 0; step < kMaxSteps && progress == Progress::kMore; ++step) {
    const double seconds = mission.record().total_seconds;
    const double metres = mission.record().metres;
    progress = mission.Step();
    loss.push_back({seconds, metres, TrueLoss(mission, *simulated.world)});
  }
  const bool settled = progress == Progress::kSettled;
  int right = 0;
  int wrong = 0;
  for (const Verdict& verdict : Judge(mission, *simulated.world)) {
    right += verdict.kind == Verdict::Kind::kRight ? 1 : 0;
    wrong += verdict.kind == Verdict::Kind::kWrong ? 1 : 0;
  }
  return {{"settled", settled},
          {"end", mission.record().end},
          {"right", right},
          {"wrong", wrong},
          {"looks", settled ? mission.record().looks.size() : setup.budget.looks},
          {"seconds", settled ? mission.record().total_seconds : setup.budget.seconds},
          {"metres", mission.record().metres},
          {"collisions", simulated.world->collisions().size()},
          {"loss", std::move(loss)}};
}

CourseMeasure NumberAt(const char* key) {
  return [key](const Json& course) { return course.at(key).get<double>(); };
}

double CourseLoss::AfterSeconds(const Json& course, double seconds) const {
  return LossAfter(course, before, 0, seconds);
}

double CourseLoss::AfterMetres(const Json& course, double metres) const {
  return LossAfter(course, before, 1, metres);
}

double CourseLoss::Mean(const Json& course, double seconds) const {
  double sum = 0.0;
  double loss = before;
  double since = 0.0;
  for (const Json& entry : course.at("loss")) {
    const double at = std::min(entry.at(0).get<double>(), seconds);
    sum += loss * (at - since);
    since = at;
    loss = entry.at(2);
  }
  return (sum + loss * (seconds - since)) / seconds;
}

void AddMeans(const std::string& metric, const std::vector<Json>& trials,
              const std::vector<Variant>& variants, const CourseMeasure& measure,
              std::vector<Row>* rows) {
  const std::string& ours = variants.back().name;
  for (const Variant& variant : variants) {
    Row row{fmt::format("{}, {}", metric, variant.name),
            Mean(ValuesOf(trials, variant.name, measure))};
    if (variant.name == ours) row.baseline = rows->back().estimate.value;
    rows->push_back(std::move(row));
  }
  for (const Variant& variant : variants) {
    if (variant.name == ours) continue;
    std::vector<double> saved = ValuesOf(trials, variant.name, measure);
    const std::vector<double> by_ours = ValuesOf(trials, ours, measure);
    for (std::size_t i = 0; i < saved.size(); ++i) saved[i] -= by_ours[i];
    rows->push_back(
        {fmt::format("{}, saved against {}", metric, variant.name), BootstrappedMean(saved)});
  }
}

void AddOutcomes(const std::vector<Json>& trials, const std::vector<Variant>& variants,
                 std::vector<Row>* rows) {
  AddMeans("looks", trials, variants, NumberAt("looks"), rows);
  AddMeans("robot time [s]", trials, variants, NumberAt("seconds"), rows);
  AddMeans("driven [m]", trials, variants, NumberAt("metres"), rows);
  AddMeans("objects right", trials, variants, NumberAt("right"), rows);
  AddMeans("verified wrongly", trials, variants, NumberAt("wrong"), rows);
  AddMeans("collisions", trials, variants, NumberAt("collisions"), rows);
}

}  // namespace secondlook::apps
