#pragma once

#include <string>
#include <vector>

#include "apps/mission_config.h"
#include "apps/scene_map.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/register_view.h"
#include "lib/perception/regroup.h"
#include "lib/perception/view.h"
#include "lib/world/scene_belief.h"

namespace secondlook::apps {

/// The things of a view, and which object each of them is: clusters[i] is objects[i]. Those that
/// are to be recognised come first, then those that a verified object explains.
struct Associated {
  std::vector<world::Cluster> clusters;
  std::vector<int> objects;  ///< Their ids.
  int open{};                ///< How many are to be recognised.
};

/// Which object of the belief each thing in a view is, and the making of one object of two, or two
/// of one, when a view shows that they are. An id is never used again: what was joined to another
/// object is rejected, with the reason.
class DataAssociation {
 public:
  /// All must outlive it. `views` are belief->views as recognition looks at them; `models` has
  /// every model that is named.
  DataAssociation(const UnderstandingConfig& config,
                  const std::vector<perception::RecognitionModel>& models,
                  world::SceneBelief* belief, std::vector<perception::View>* views, SceneMap* map);

  /// The things of a view that was registered as it says. What is verified takes from `clusters`
  /// what it explains; the rest is matched with the open objects, by place and footprint.
  Associated Associate(std::vector<world::Cluster> clusters, const cv::Mat& depth,
                       const hal::CameraModel& camera,
                       const perception::ViewRegistration& registration);

  /// The objects that the detections in `found`, of a view from X_WC, are; what was recognised were
  /// the things of `objects`, of which recognition may have cut some and joined others.
  std::vector<int> AfterRegrouping(const perception::Regrouped& found, const Pose& X_WC,
                                   const std::vector<int>& objects);

  /// Makes one object of all `ids`, the first of them; a new one when there are none. Returns its
  /// id.
  int Merge(const std::vector<int>& ids);

  /// True when both are one thing: its two ends, each recognised by itself, or an open one that is
  /// a piece of a verified one.
  bool AreOne(const world::ObjectBelief& a, const world::ObjectBelief& b) const;

  /// Notes that detection `detection` of `view` shows `object`.
  void AddSighting(int view, int detection, world::ObjectBelief* object) const;

 private:
  using ObjectBelief = world::ObjectBelief;

  Associated TakeVerified(const cv::Mat& depth, const hal::CameraModel& camera, const Pose& X_WC,
                          std::vector<world::Cluster>* clusters) const;
  Associated MatchOpen(const std::vector<world::Cluster>& clusters, const cv::Mat& depth,
                       const hal::CameraModel& camera,
                       const perception::ViewRegistration& registration);
  world::Cluster TakeExplained(const world::PoseHypothesis& thing, const Pose& X_WC,
                               const cv::Mat& depth, const hal::CameraModel& camera,
                               int min_leftover_points,
                               std::vector<world::Cluster>* clusters) const;
  bool IsEnough(const world::Cluster& cluster) const;
  std::vector<int> ToldApart(const std::vector<int>& ids) const;
  std::vector<int> Split(int id, const std::vector<world::PoseHypothesis>& things);
  void AddDetection(int view, world::Cluster cluster, ObjectBelief* object);
  void MovePiece(const world::Sighting& from, const world::Sighting& to, ObjectBelief* whole);
  bool AreOneModel(const ObjectBelief& a, const ObjectBelief& b) const;
  bool IsPartOf(const ObjectBelief& object, const ObjectBelief& whole) const;
  const perception::RecognitionModel& ModelOf(const std::string& name) const;

  const UnderstandingConfig& config_;
  const std::vector<perception::RecognitionModel>& models_;
  world::SceneBelief& belief_;
  std::vector<perception::View>& views_;
  SceneMap& map_;
};

}  // namespace secondlook::apps
