#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/experiments/statistics.h"

namespace secondlook::apps {

/// What every experiment is asked for (docs/cli.md).
struct ExperimentOptions {
  int trials = 50;
  int views{};  ///< Of each trial, for the experiments that take views of a scene.
  std::uint64_t seed = 1;
  int shard = 1;  ///< Of `shards`, from 1: only trials t with t % shards == shard - 1 are run.
  int shards = 1;
  bool resume{};           ///< Trials that stand in `json` already are not run again.
  std::string scene;       ///< A scene file to use instead of random ones; "": random.
  std::string models;      ///< Folder of the object database.
  std::string unfamiliar;  ///< Folder of objects that are in no database; "": none.
  std::string data;        ///< Folder of recorded data, for the experiments that need it.
  std::string classifier;  ///< Model file of a classifier, for the experiments that need one.
  bool mirror{};           ///< Each set of recorded data is seen in a mirror or not, by chance.
  std::string report;      ///< Folder that keeps the scene and result of each trial; "": none.
  std::string json;        ///< Where the result goes; "-": standard output, "": nowhere.
  int threads = 2;         ///< Trials side by side.
};

/// One line of an experiment's result.
struct Row {
  std::string metric;
  Estimate estimate;
  std::optional<double> paper{};     ///< The published figure.
  std::optional<double> baseline{};  ///< The same figure by the simpler method, in the same trials.
};

/// Runs `trial(t)` for the trials of the shard, side by side, and returns their results in the
/// order of t. After each one, or less often where that would take long, those that are done are
/// written to `options.json`, so that --resume can go on from there; `summarise` makes the rows
/// from all that are done.
std::vector<nlohmann::ordered_json> RunTrials(
    const std::string& name, const ExperimentOptions& options,
    const std::function<nlohmann::ordered_json(int)>& trial,
    const std::function<std::vector<Row>(const std::vector<nlohmann::ordered_json>&)>& summarise);

/// Whole missions in simulation: the figures by which the default robot is judged.
/// @throws ConfigError for folders or a scene that cannot be read.
void RunMissionsExperiment(const ExperimentOptions& options);

/// Whole missions with one to three faults each of devices, disk, network or clock, and a stop at a
/// random moment among them. The baseline is the same mission without.
void RunFaultsExperiment(const ExperimentOptions& options);

/// Recognition in recorded frames with ground truth, nothing told of where objects are: a trial is
/// a frame of the folder `options.data`.
/// @throws ConfigError for a folder that has no such frame, or a frame that cannot be read.
void RunRealFramesExperiment(const ExperimentOptions& options);

/// Second views of an object chosen from a first one, on the data set of Hoseini 2021 or any part
/// of it (`options.data`): a trial is a set, with both initial views in 15 cases each. The baseline
/// is the single view.
/// @throws ConfigError without `options.classifier`, for a folder without sets, or files that
/// cannot be read.
void RunNbvDatasetExperiment(const ExperimentOptions& options);

/// Eight things on a table seen by the camera on the head and the one in the hand, and what they
/// are by either or both (Hoseini 2018, Section 3), with and without things that hide parts of
/// some. A trial is a table. Without `options.classifier` a machine is trained on rendered
/// pictures.
/// @throws ConfigError for a folder of fewer than eight models, or a classifier of other classes.
void RunDsFusionExperiment(const ExperimentOptions& options);

/// Segmentation of clouds in which each point is labelled: a trial is a PCD of the folder
/// `options.data`, or without one a simulated view of a crowded table. The baseline is the same
/// without splitting what touches. `options.trials` 0: all clouds, or 50 views.
/// @throws ConfigError for a folder that has no such file, or a file that cannot be read.
void RunSegmentationExperiment(const ExperimentOptions& options);

/// Recognition in single views, each from scratch, as in Section IV-C of Kriegel 2013: a trial is a
/// crowded table with seven objects, which are all that its database holds. The baseline is the
/// paper's decision on the same hypotheses: the best quality q_h above 0.4.
/// @throws ConfigError for a folder of models that cannot be read.
void RunRecognitionExperiment(const ExperimentOptions& options);

/// One object at a time scanned by a laser striper and by a depth camera from a fixed ring of poses
/// (Kriegel 2013, IV-A), with the errors of the arm that carries them: how much of its surface each
/// brings, and how exactly. A trial is an object. The baseline of the striper is the camera.
/// @throws ConfigError for a folder of models that cannot be read.
void RunSensorsExperiment(const ExperimentOptions& options);

/// The pose of one object fused over planned views, as in Fig. 7 of Kriegel 2013: a trial is an
/// object by itself on a pedestal. The baseline is the paper's average, the mean of the largest
/// cluster of what the views say singly.
/// @throws ConfigError for a folder of models that cannot be read.
void RunPoseAveragingExperiment(const ExperimentOptions& options);

/// McGreavy 2016, Section 5: looks chosen in several ways, from the same starts and with the same
/// views. A trial is an object on a plinth that the first view shows badly.
/// @throws ConfigError for a folder of models that cannot be read; here and below.
void RunUnobstructedExperiment(const ExperimentOptions& options);
/// … that the first view recognises, to be confirmed by another.
void RunConfirmationExperiment(const ExperimentOptions& options);
/// … that something else hides in part.
void RunOcclusionExperiment(const ExperimentOptions& options);
/// … that has a twin, from which the first view cannot tell it.
/// @throws ConfigError when the models do not have the twins, too.
void RunAmbiguityExperiment(const ExperimentOptions& options);
/// Beside the paper: whether things that are in no database, for which the first view has a
/// hypothesis, are called unknown, and true ones are not.
/// @throws ConfigError without unfamiliar objects, too.
void RunRejectionExperiment(const ExperimentOptions& options);
/// Beside the paper: base poses that are accepted or refused from what was seen, held against the
/// true meshes. A trial is a random scene, seen one to four times.
void RunReachabilityExperiment(const ExperimentOptions& options);
/// Beside the paper: whole missions among people who close the ways.
void RunMovingObstaclesExperiment(const ExperimentOptions& options);
/// Whole missions on a table crowded with eight things, with and without what is verified standing
/// in the map as its whole model.
void RunRecognisedObjectsExperiment(const ExperimentOptions& options);
/// … with looks chosen by the expected drop of the task's loss, and by McGreavy 2016.
void RunSearchExperiment(const ExperimentOptions& options);
/// Missions that can look with head and hand, at things with twins and things behind others: looks
/// in one common currency, and the papers' planners in a fixed order. Without `options.classifier`
/// things are known by shape alone.
/// @throws ConfigError when the models do not have the twins, too.
void RunOneBudgetExperiment(const ExperimentOptions& options);
/// One thing on a crowded table, of ten models, from its cluster alone. A trial is a table; the
/// baseline is OpenCV's PPF3DDetector with its ICP on the same cluster.
/// @throws ConfigError for a folder of models that cannot be read.
void RunPpfPeersExperiment(const ExperimentOptions& options);
/// Things modelled by scans from planned views, as in Sections III-B, III-D and IV-B of Kriegel
/// 2013. A trial is an object by itself on a table, of the known and the unfamiliar ones in turn.
/// @throws ConfigError for a folder of models that cannot be read.
void RunModellingExperiment(const ExperimentOptions& options);
/// Whole missions on a table with six things of which three are in the database and the others are
/// to be modelled (Kriegel 2013, IV-D), by several ways to choose scans. A trial is a table.
/// @throws ConfigError for a folder of models that cannot be read, or without unfamiliar objects.
void RunExplorationExperiment(const ExperimentOptions& options);
/// Models made by such missions, recognised on other tables in single views of the depth camera. A
/// trial is a mission and the views that follow.
/// @throws ConfigError likewise.
void RunReuseExperiment(const ExperimentOptions& options);

}  // namespace secondlook::apps
