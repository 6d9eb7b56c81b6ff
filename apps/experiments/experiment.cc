#include "apps/experiments/experiment.h"

#include <ctime>
#include <filesystem>
#include <mutex>
#include <optional>

#include <fmt/format.h>

#include "apps/json_output.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/parallel.h"
#include "lib/common/stopwatch.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

/// A result that takes long to summarise and write is written after so many times as long.
constexpr double kTimesWriting = 20.0;

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Json OrNull(const std::optional<double>& figure) { return figure ? Json(*figure) : Json(nullptr); }

/// The trials that stand in the result of an earlier, interrupted run.
std::vector<Json> EarlierTrials(const std::string& name, const ExperimentOptions& options) {
  if (!options.resume || options.json.empty() || options.json == "-") return {};
  if (!std::filesystem::exists(options.json)) return {};
  const Json earlier = Json::parse(ReadFile(options.json), nullptr, false);
  const bool fits = earlier.is_object() && earlier.value("name", "") == name &&
                    earlier.value("seed", std::uint64_t{0}) == options.seed &&
                    earlier.value("scene", "") == options.scene &&
                    earlier.value("models", "") == options.models &&
                    earlier.value("views", 0) == options.views && earlier.contains("details") &&
                    earlier["details"].is_array();
  if (!fits) {
    Throw<ConfigError>(
        "{}: is not the result of 'experiment {}' with seed {}, models '{}', scene '{}' and {} "
        "views; nothing to resume",
        options.json, name, options.seed, options.models, options.scene, options.views);
  }
  return earlier["details"].get<std::vector<Json>>();
}

Json ResultOf(const std::string& name, const ExperimentOptions& options,
              const std::vector<Json>& details, const std::vector<Row>& rows, double seconds) {
  Json result;
  result["name"] = name;
  result["trials"] = details.size();
  result["seed"] = options.seed;
  result["scene"] = options.scene;
  result["models"] = options.models;
  if (options.views > 0) result["views"] = options.views;
  result["rows"] = Json::array();
  for (const Row& row : rows) {
    result["rows"].push_back({{"metric", row.metric},
                              {"value", row.estimate.value},
                              {"ci95", {row.estimate.low, row.estimate.high}},
                              {"paper", OrNull(row.paper)},
                              {"baseline", OrNull(row.baseline)}});
  }
  result["seconds"] = seconds;
  result["details"] = details;
  return result;
}

void Print(const std::string& name, std::uint64_t seed, std::size_t trials,
           const std::vector<Row>& rows) {
  fmt::print("\n{} ({} trials, seed {})\n", name, trials, seed);
  for (const Row& row : rows) {
    fmt::print("  {:50} {:9.4f}   95 % [{:.4f}, {:.4f}]{}{}\n", row.metric, row.estimate.value,
               row.estimate.low, row.estimate.high,
               row.paper ? fmt::format("   paper {:.4f}", *row.paper) : "",
               row.baseline ? fmt::format("   baseline {:.4f}", *row.baseline) : "");
  }
}

}  // namespace

std::vector<Json> RunTrials(
    const std::string& name, const ExperimentOptions& options,
    const std::function<Json(int)>& trial,
    const std::function<std::vector<Row>(const std::vector<Json>&)>& summarise) {
  std::vector<std::optional<Json>> done(options.trials);
  for (const Json& earlier : EarlierTrials(name, options)) {
    const int t = earlier.value("trial", -1);
    if (t >= 0 && t < options.trials) done[t] = earlier;
  }
  std::vector<int> open;
  for (int t = 0; t < options.trials; ++t) {
    if (t % options.shards == options.shard - 1 && !done[t]) open.push_back(t);
  }
  const auto details = [&] {
    std::vector<Json> all;
    for (const auto& one : done) {
      if (one) all.push_back(*one);
    }
    return all;
  };
  const double start = ProcessorSeconds();
  const auto result = [&] {
    return ResultOf(name, options, details(), summarise(details()), ProcessorSeconds() - start);
  };
  std::mutex mutex;  // guards what follows, `done` and the file
  Stopwatch since_written;
  double written_in = 0.0;  // [s]
  const ThreadLimit limit(options.threads);
  ParallelFor(static_cast<int>(open.size()), [&](int i) {
    Json one = trial(open[i]);
    one["trial"] = open[i];
    const std::lock_guard lock(mutex);
    done[open[i]] = std::move(one);
    if (options.json.empty() || options.json == "-") return;
    if (since_written.Seconds() < kTimesWriting * written_in) return;
    const Stopwatch writing;
    WriteJson(result(), options.json);
    written_in = writing.Seconds();
    since_written = {};
  });
  const Json all = result();
  if (!options.json.empty()) WriteJson(all, options.json);
  if (options.json != "-") Print(name, options.seed, details().size(), summarise(details()));
  return details();
}

}  // namespace secondlook::apps
