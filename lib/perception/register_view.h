#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/mesh.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// Of a small error of a pose X_AB: (rotation vector [rad] about B's origin, translation [m]), both
/// in A.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// A measured or modelled point of a surface, in some frame A.
struct SurfacePoint {
  Eigen::Vector3d p_AP;      ///< [m]
  Eigen::Vector3d normal_A;  ///< Unit, outward.
  double sigma{};            ///< How far the surface may be off along the normal [m].
};

/// How well a nominal camera pose is known (standard deviations), and how views are registered.
struct RegisterConfig {
  double base_m{0.015};            ///< Of the base's x and y.
  double base_yaw_deg{0.7};        ///< Of its heading.
  double extrinsics_m{0.003};      ///< Of the camera on the base, along each axis.
  double extrinsics_deg{0.35};     ///< About each axis, the head's own error included.
  double plane_spacing_m{0.05};    ///< Between the points taken of the support plane, and…
  double object_spacing_m{0.008};  ///< …of what stands on it.
  double plane_height_m{0.012};    ///< What is lower is the plane.
  double max_height_m{0.6};        ///< What is higher is left out.
  double edge_drop_m{0.015};       ///< Beside the plane's edge one sees what lies lower by so much.
  int edge_gap_px{8};              ///< So many pixels may lie between.
  double edge_face_m{0.03};        ///< Nearer to the edge, what lies lower is the upright side.
  double edge_radius_m{0.05};      ///< Edge points so near to each other give the edge's direction.
  double edge_sigma_m{0.004};      ///< How well an edge is measured.
  double plane_margin_m{0.03};     ///< How far beyond the plane's rectangle points may lie.
  double first_gate_m{0.08};       ///< Pairs farther apart are none, at first and…
  double last_gate_m{0.01};        ///< …at the end.
  double max_normal_angle_deg{35};  ///< Between the normals of a pair.
  double max_slide_m{1.0};  ///< Pairs farther apart along the surface are none: one ends there.
  int iterations{30};
  double min_constraint{0.005};       ///< Of SolvePointToPlane: less of the weight holds nothing.
  int min_pairs{100};                 ///< Fewer are no registration.
  double common_shift_m{0.001};       ///< All pairs may be off together by this.
  double pairs_per_independent{5.0};  ///< So many pairs say as much as one independent one.
  double max_sigmas{5.0};  ///< Pairs that contradict the nominal pose by more are refused.

  template <class A>
  void Serialize(A* a) {
    a->Visit("base_m", &base_m);
    a->Visit("base_yaw_deg", &base_yaw_deg);
    a->Visit("extrinsics_m", &extrinsics_m);
    a->Visit("extrinsics_deg", &extrinsics_deg);
    a->Visit("plane_spacing_m", &plane_spacing_m);
    a->Visit("object_spacing_m", &object_spacing_m);
    a->Visit("plane_height_m", &plane_height_m);
    a->Visit("max_height_m", &max_height_m);
    a->Visit("edge_drop_m", &edge_drop_m);
    a->Visit("edge_gap_px", &edge_gap_px);
    a->Visit("edge_face_m", &edge_face_m);
    a->Visit("edge_radius_m", &edge_radius_m);
    a->Visit("edge_sigma_m", &edge_sigma_m);
    a->Visit("plane_margin_m", &plane_margin_m);
    a->Visit("first_gate_m", &first_gate_m);
    a->Visit("last_gate_m", &last_gate_m);
    a->Visit("max_normal_angle_deg", &max_normal_angle_deg);
    a->Visit("max_slide_m", &max_slide_m);
    a->Visit("iterations", &iterations);
    a->Visit("min_constraint", &min_constraint);
    a->Visit("min_pairs", &min_pairs);
    a->Visit("common_shift_m", &common_shift_m);
    a->Visit("pairs_per_independent", &pairs_per_independent);
    a->Visit("max_sigmas", &max_sigmas);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The covariance of a nominal X_WC in the map that another view of the same quality has defined,
/// perhaps from the other side: both err. `p_CB_W` is from the camera to the base's origin, in W
/// [m].
PoseCovariance NominalCovariance(const RegisterConfig& config, const Eigen::Vector3d& p_CB_W);

/// The same where the base has not moved since another view was registered with `covariance`, so
/// that it is known where the base stands: what that view and the two cameras on the base err by
/// remains. `p_OC_W` is from the other camera to this one, in W [m].
PoseCovariance CovarianceBeside(const RegisterConfig& config, const PoseCovariance& covariance,
                                const Eigen::Vector3d& p_OC_W);

/// The points of a view that registration uses, in C: of the support plane within its rectangle,
/// and of what stands on it, thinned, each with the normal of its surroundings. The plane's edge
/// is there, too, as points of an upright surface: from opposite sides the edge is most of what two
/// views have in common besides the plane.
/// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none.
/// @throws InvalidArgument for a depth image of another type or size than the camera's.
std::vector<SurfacePoint> ViewPoints(const cv::Mat& depth, const geometry::CameraModel& camera,
                                     const world::SupportPlane& plane_C,
                                     const RegisterConfig& config = {});

/// What views are registered to: the surfaces seen so far and those of verified models, in W. Of
/// each cell of a grid it keeps the mean of the points whose normals have the same main direction,
/// weighted by what they are worth.
class ReferenceCloud {
 public:
  /// @throws InvalidArgument unless cell > 0 [m].
  explicit ReferenceCloud(double cell = 0.005);

  bool empty() const { return cells_.empty(); }

  /// Adds a view taken at `X_WC`, which is known up to `covariance`: the points are worth less
  /// accordingly. The first view defines the map and has none.
  /// @throws InvalidArgument for a pose that is not valid or a covariance that is not finite.
  void AddView(const std::vector<SurfacePoint>& points_C, const Pose& X_WC,
               const PoseCovariance& covariance = PoseCovariance::Zero());

  /// Adds the surface of a verified model whose pose is known up to `sigma` [m] at each point.
  /// @throws InvalidArgument for an empty mesh, a pose that is not valid, or sigma <= 0.
  void AddModel(const geometry::Mesh& mesh, const Pose& X_WM, double sigma);

  /// Drops what lies in the box, e.g. where a model was rejected or something was moved.
  void Remove(const Eigen::AlignedBox3d& box_W);

  /// All points, cell by cell.
  std::vector<SurfacePoint> Points() const;

 private:
  using Key = std::array<int, 4>;  ///< Cell, and the main direction of the normal.
  struct Sum {
    Eigen::Vector3d point{Eigen::Vector3d::Zero()};   ///< Times weight.
    Eigen::Vector3d normal{Eigen::Vector3d::Zero()};  ///< Times weight.
    double weight{};                                  ///< Sum of 1 / sigma^2.
    double sigma{};  ///< Of the best point: errors of one view are not independent.
  };
  void Add(const SurfacePoint& point_W);

  double cell_;
  std::map<Key, Sum> cells_;
};

/// How a view fits the map.
struct ViewRegistration {
  /// The most probable pose by what was seen and by where the camera should be; the nominal one
  /// where it was refused.
  Pose X_WC{Pose::Identity()};
  PoseCovariance covariance{PoseCovariance::Zero()};  ///< Of X_WC.
  int constrained{};                                  ///< Directions held by the data, 0 .. 6.
  int pairs{};                                        ///< Of the last iteration.
  double rms{};     ///< Of the distances of these along the normals [m].
  double sigmas{};  ///< Mahalanobis distance between what pairs and nominal pose say, by both.
  bool accepted{};
  std::string reason;  ///< Why not, with values; empty when accepted.
};

/// Registers a view to the map by robust point-to-plane ICP (Chen and Medioni 1992): nearest
/// neighbours of compatible normals within a gate that shrinks, Tukey weights, by the sensor's and
/// the map's uncertainty. Every step weighs the nominal pose, too, by its covariance: what pairs
/// hold little stays near it instead of sliding. A result is refused when pairs and nominal pose
/// contradict each other.
/// @param nominal_X_WC What localisation, head and calibration say, known up to `covariance`.
/// @throws InvalidArgument for an empty reference, a pose that is not valid, or a covariance that
/// is not positive definite. ConfigError when `config` is not valid.
ViewRegistration RegisterView(const std::vector<SurfacePoint>& points_C,
                              const ReferenceCloud& reference, const Pose& nominal_X_WC,
                              const PoseCovariance& covariance, const RegisterConfig& config = {});

}  // namespace secondlook::perception
