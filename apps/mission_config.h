#pragma once

#include <optional>

#include "apps/arm_looks.h"
#include "apps/modelling_config.h"
#include "lib/common/error.h"
#include "lib/fusion/conclude.h"
#include "lib/perception/recognise.h"
#include "lib/perception/register_view.h"
#include "lib/perception/segment.h"
#include "lib/planning/aspect_graph.h"
#include "lib/planning/cost_map.h"
#include "lib/planning/hidden_space.h"
#include "lib/planning/views.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// @throws ConfigError naming `name` when `value` is less than `least`.
inline void RequireAtLeast(const char* name, double value, double least) {
  if (!(value >= least)) Throw<ConfigError>("{} = {} must be at least {}", name, value, least);
}

/// How a view is understood: what SceneUnderstanding needs.
struct UnderstandingConfig {
  perception::SegmentConfig segment;
  perception::RegisterConfig registration;
  perception::RecogniseConfig recognise;
  fusion::ConcludeConfig conclude;
  world::VoxelSpaceConfig voxel_space;
  int depth_stride = 2;            ///< Every so many pixels of a row and column enter the voxels.
  double floor_clearance_m = 0.3;  ///< Support planes are higher above the floor than this.
  double footprint_cell_m = 0.01;  ///< Of the footprints by which views are matched.
  double footprint_overlap = 0.3;  ///< From which two footprints are one thing.
  double match_sigmas = 3.37;      ///< Farther apart, by the errors of views, they are two.
  double moved_within_m = 0.4;     ///< What is gone, and reappears so near, was moved.
  int min_leftover_points = 400;   ///< What known things leave of a cluster is something else.
  /// Of the pixels of verified objects in a view; more, and its registration is not believed.
  double max_see_through = 0.25;
  int clear_view_points = 300;  ///< A thing seen with fewer was not seen clearly.
  bool known_in_map = true;     ///< What is verified stands in the map as its whole model.

  template <class A>
  void Serialize(A* a) {
    a->Visit("segment", &segment);
    a->Visit("registration", &registration);
    a->Visit("recognise", &recognise);
    a->Visit("conclude", &conclude);
    a->Visit("voxel_space", &voxel_space);
    a->Visit("depth_stride", &depth_stride);
    a->Visit("floor_clearance_m", &floor_clearance_m);
    a->Visit("footprint_cell_m", &footprint_cell_m);
    a->Visit("footprint_overlap", &footprint_overlap);
    a->Visit("match_sigmas", &match_sigmas);
    a->Visit("moved_within_m", &moved_within_m);
    a->Visit("min_leftover_points", &min_leftover_points);
    a->Visit("max_see_through", &max_see_through);
    a->Visit("clear_view_points", &clear_view_points);
    a->Visit("known_in_map", &known_in_map);
  }

  /// @throws ConfigError naming the value.
  void Validate() const {
    segment.Validate();
    registration.Validate();
    recognise.Validate();
    conclude.Validate();
    voxel_space.Validate();
    RequireAtLeast("depth_stride", depth_stride, 1);
    RequireAtLeast("floor_clearance_m", floor_clearance_m, 0);
    RequireAtLeast("footprint_cell_m", footprint_cell_m, 0.001);
    RequireAtLeast("footprint_overlap", footprint_overlap, 0);
    RequireAtLeast("match_sigmas", match_sigmas, 0.1);
    RequireAtLeast("moved_within_m", moved_within_m, 0);
    RequireAtLeast("min_leftover_points", min_leftover_points, 0);
    RequireAtLeast("clear_view_points", clear_view_points, 0);
  }
};

/// How looks are planned and taken: what Mission needs beside.
struct LookConfig {
  planning::CostMapConfig cost_map;
  planning::ViewsConfig views;
  planning::AspectGraphConfig aspect_graph;
  planning::HiddenSpaceConfig hidden_space;
  ArmLooksConfig arm;
  int per_object = 4;               ///< After so many for its sake an object is left open.
  int at_hidden_space = 3;          ///< Looks where something could stand unseen.
  double frame_timeout_s = 1.0;     ///< Waited for a frame …
  int frame_tries = 3;              ///< … so many times before the camera counts as lost; so many
                                    ///< frames in a row without depth count as that, too.
  double blocked_radius_m = 0.25;   ///< Entered where the base was stopped by something unseen …
  double blocked_seconds = 60.0;    ///< … for so long: it may have moved on.
  double understand_seconds = 1.0;  ///< What understanding a frame is charged in simulation.
  double plan_seconds = 0.5;        ///< What choosing a look is charged in simulation.

  template <class A>
  void Serialize(A* a) {
    a->Visit("cost_map", &cost_map);
    a->Visit("views", &views);
    a->Visit("aspect_graph", &aspect_graph);
    a->Visit("hidden_space", &hidden_space);
    a->Visit("arm", &arm);
    a->Visit("per_object", &per_object);
    a->Visit("at_hidden_space", &at_hidden_space);
    a->Visit("frame_timeout_s", &frame_timeout_s);
    a->Visit("frame_tries", &frame_tries);
    a->Visit("blocked_radius_m", &blocked_radius_m);
    a->Visit("blocked_seconds", &blocked_seconds);
    a->Visit("understand_seconds", &understand_seconds);
    a->Visit("plan_seconds", &plan_seconds);
  }

  /// @throws ConfigError naming the value.
  void Validate() const {
    cost_map.Validate();
    views.Validate();
    aspect_graph.Validate();
    hidden_space.Validate();
    arm.Validate();
    RequireAtLeast("per_object", per_object, 0);
    RequireAtLeast("at_hidden_space", at_hidden_space, 0);
    RequireAtLeast("frame_timeout_s", frame_timeout_s, 0);
    RequireAtLeast("frame_tries", frame_tries, 1);
    RequireAtLeast("blocked_radius_m", blocked_radius_m, 0);
    RequireAtLeast("blocked_seconds", blocked_seconds, 0);
    RequireAtLeast("understand_seconds", understand_seconds, 0);
    RequireAtLeast("plan_seconds", plan_seconds, 0);
  }
};

/// How a mission goes about it.
struct MissionConfig {
  UnderstandingConfig understanding;
  LookConfig looks;
  std::optional<ModellingConfig> modelling;  ///< Of what it does not know; empty: it stays unknown.

  template <class A>
  void Serialize(A* a) {
    a->Visit("understanding", &understanding);
    a->Visit("looks", &looks);
    a->Visit("modelling", &modelling);
  }
};

}  // namespace secondlook::apps
