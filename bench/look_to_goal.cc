// From what is believed after a view to the goal that is sent: the default mission's first choice,
// two threads, all included (regions nobody has seen, candidates and their checks, rays,
// look-ahead, the choice, all candidates and the goal as messages). First the gate: one thread and
// two choose the same look with the same score, a goal is sent, and the base fits there among the
// true meshes; the status is 1 when not.
//   look_to_goal [--benchmark_…]
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/sight.h"
#include "apps/experiments/true_footing.h"
#include "apps/look_planner.h"
#include "apps/publisher.h"
#include "lib/common/parallel.h"
#include "lib/planning/choose_look.h"
#include "lib/planning/hidden_space.h"
#include "lib/transport/channels.h"

namespace secondlook::bench {
namespace {

constexpr const char* kScene = "sim/scenes/default.yaml";
constexpr const char* kModels = "sim/models";

/// Counts what is sent, and keeps the last goal.
class Listener : public transport::Sink {
 public:
  void Post(const transport::Message& message) override {
    bytes += message.bytes.size();
    goals += message.channel == transport::channel::kNavGoal;
  }
  std::size_t bytes{};
  int goals{};
};

/// The default mission after its first view.
struct AfterOneView {
  AfterOneView() : database(world::ObjectDatabase::Load(kModels)) {
    const sim::RobotStart& start = camera.world().scene().robot;
    stance.X_WB = {start.position.x(), start.position.y(), start.yaw_deg * M_PI / 180.0};
    stance.head = {0.0, 0.35};
    Rng rng(1);
    known.Add(apps::LookFrom(stance, &rng, &camera).capture);
  }

  apps::FreeCamera camera{sim::LoadScene(kScene), 1};
  world::ObjectDatabase database;
  world::Task task;
  apps::UnderstandingConfig understanding;
  apps::LookConfig config;
  apps::Stance stance;
  apps::SceneUnderstanding known{understanding, task, database};
};

const AfterOneView& TheMission() {
  static const AfterOneView mission;
  return mission;
}

/// What a mission does between a view and setting out.
planning::LookChoice Choose(const AfterOneView& m, const apps::SceneUnderstanding& known,
                            std::vector<world::Look>* looks, Listener* listener) {
  apps::Publisher publisher({listener});
  apps::LookPlanner planner(m.config, m.understanding, apps::CarrierOf(m.camera));
  apps::Question question;
  std::vector<Eigen::AlignedBox3d> known_W;
  for (const world::ObjectBelief& object : known.belief().objects) {
    known_W.push_back(object.extent_W);
    if (!object.Settled()) question.open.push_back(&object);
  }
  question.hidden_W = planning::HiddenRegions(known.space(), *known.belief().plane_W, known_W,
                                              m.config.hidden_space);
  Rng rng(1);
  *looks = planner.Candidates(known, m.task, question, m.stance, &rng);
  const planning::LookChoice choice = planning::ChooseLook(looks);
  publisher.Candidates(*looks, Time{});
  if (choice.index) publisher.Look((*looks)[*choice.index], Time{});
  return choice;
}

bool Agree() {
  const AfterOneView& m = TheMission();
  std::vector<world::Look> looks;
  std::vector<std::string> chosen;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    Listener listener;
    const planning::LookChoice choice = Choose(m, m.known, &looks, &listener);
    if (!choice.index || listener.goals != 1) {
      fmt::print("no goal was sent: {}\n", choice.reason);
      return false;
    }
    chosen.push_back(fmt::format("{} {}", *choice.index, choice.reason));
  }
  const world::Look* look = nullptr;
  for (const world::Look& candidate : looks) {
    if (candidate.chosen) look = &candidate;
  }
  const hal::BaseInfo base = apps::CarrierOf(m.camera).base;
  const bool fits = apps::TrueFooting(m.camera.world().fixtures())
                        .Free({look->X_WB.x, look->X_WB.y}, base.radius, 0.0, base.height);
  fmt::print("{} candidates; {}\n", looks.size(), chosen.back());
  return chosen.front() == chosen.back() && fits;
}

void FromBeliefToGoal(benchmark::State& state) {
  const AfterOneView& m = TheMission();
  const ThreadLimit two(2);
  for (auto _ : state) {
    std::vector<world::Look> looks;
    Listener listener;
    Choose(m, m.known, &looks, &listener);
    benchmark::DoNotOptimize(listener.bytes);
  }
}
BENCHMARK(FromBeliefToGoal)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::err);
  benchmark::Initialize(&argc, argv);
  if (!secondlook::bench::Agree()) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
