#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "apps/modelling_config.h"
#include "apps/partial_model.h"
#include "lib/common/pose.h"
#include "lib/planning/scan_gain.h"
#include "lib/world/object_database.h"
#include "lib/world/scene_belief.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// What came of modelling a thing.
struct ModelledThing {
  int object{};                      ///< Its id.
  std::string model;                 ///< Its name; empty: none was made.
  std::vector<double> coverage;      ///< After each scan, of what the support leaves free.
  std::vector<std::string> refused;  ///< Why scans were not fused, one by one.
  std::string reason;                ///< Why it is done, or why there is no model.
  world::ScannedModel scanned;       ///< Without triangles when there is no model.
  Pose X_WM{Pose::Identity()};       ///< Where it stands.
  std::string not_kept;              ///< Why the model could not be kept; empty: it was.
};

/// What was scanned as recognition knows it, without any files: the mesh, and a hash of it.
world::ObjectModel AsModel(const world::ScannedModel& scanned);

/// What the next scan is to add to.
struct ScanTarget {
  int object{};                                     ///< Its id.
  Eigen::AlignedBox3d box_W;                        ///< Around what is seen of it.
  const planning::ScanGainField* gain{};            ///< Not null; what a scan would show.
  double surface{};                                 ///< That is seen so far [m^2].
  int scans{};                                      ///< So far.
  Eigen::Vector3d last_W{Eigen::Vector3d::Zero()};  ///< Where the last was made from.
  std::vector<Eigen::Vector3d> refused_W{};         ///< Scans from there were not fused.
};

/// Models what is settled as unknown, one thing after the other, the largest first, by the views of
/// the mission (Kriegel 2013, Fig. 2): each that shows it is a scan. What is recognised meanwhile,
/// or gone from its place, needs no model.
class Exploration {
 public:
  /// Names are not those in `known`.
  /// @throws ConfigError when `config` is not valid.
  Exploration(const ModellingConfig& config, const world::ObjectDatabase& known);

  /// Enters what the views since the last time show, and begins with the next thing when there is
  /// none. Returns a thing that is done, and why; empty when the next needs another scan, or none
  /// is left. To be called until it returns nothing.
  /// @param now Of the robot's clock.
  std::optional<ModelledThing> Work(const world::SceneBelief& belief, Time now);

  /// The thing that is being modelled and what scans of it would bring; empty: none is.
  /// @pre Work() has returned nothing since the last view.
  std::optional<ScanTarget> Target(const world::SceneBelief& belief,
                                   const world::VoxelSpace& space);

  /// The thing that is being modelled is done, as it cannot be scanned again, because of `why`.
  ModelledThing Finish(const world::SceneBelief& belief, const std::string& why, Time now);

  /// Likewise, if one is being modelled: the mission ends, because of `why`.
  std::optional<ModelledThing> FinishAny(const world::SceneBelief& belief, const std::string& why,
                                         Time now) {
    if (!current_) return std::nullopt;
    return Finish(belief, why, now);
  }

  /// Things that need not be recognised in the next views: too many have not known them.
  std::set<int> NotToRecognise() const;

 private:
  /// The thing that is being modelled.
  struct Current {
    int object{};
    PartialModel model;
    int views_before{};                    // it was begun
    std::set<int> entered{};               // views
    std::map<int, std::string> refused{};  // of these, and why
    std::vector<double> coverage{};
  };

  const world::ObjectBelief* LargestUnknown(const world::SceneBelief& belief) const;
  void Begin(const world::ObjectBelief& object, const world::SceneBelief& belief);
  void Enter(const world::ObjectBelief& object, const world::SceneBelief& belief);
  std::string Fuse(int view, const world::ObjectBelief& object, const world::SceneBelief& belief);
  ModelledThing Drop(const std::string& why);
  std::string UnusedName();

  ModellingConfig config_;
  std::set<std::string> names_;  // that are taken
  std::set<int> done_;           // objects
  std::optional<Current> current_;
  std::optional<planning::ScanGainField> gain_;
};

}  // namespace secondlook::apps
