#include "lib/world/ray_cast.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lib/common/error.h"

namespace secondlook::world {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Stands for 1 / 0: no face is ever met along that axis.
constexpr double kNever = 1e300;

double Inverse(double value) { return std::abs(value) < 1.0 / kNever ? kNever : 1.0 / value; }

/// Rays through one grid, in voxels from its first. `leap` says what they must see of it.
template <Leap leap>
class Caster {
 public:
  Caster(const BrickGrid& grid, const LeapField& leaps, const Vector3d& p_WA, RayStop stop)
      : leaps_(leaps),
        stop_(stop),
        first_(grid.first_key()),
        size_(grid.brick_count() * Brick::kEdge),
        from_(p_WA / grid.voxel() - first_.cast<double>()) {}

  /// Follows the ray `way` from `begin` on, up to `end`, in lengths of it; `unknown` was met
  /// before.
  RayEnd Follow(const Vector3d& way, double begin, double end, double unknown) const {
    RayEnd result;
    result.at = end;
    result.unknown = unknown;
    const Vector3d inverse(Inverse(way.x()), Inverse(way.y()), Inverse(way.z()));
    double t = begin;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = -from_[axis] * inverse[axis];
      const double b = (size_[axis] - from_[axis]) * inverse[axis];
      t = std::max(t, std::min(a, b));
      end = std::min(end, std::max(a, b));
    }
    if (!(t < end)) return result;
    Vector3i voxel = VoxelAround(from_ + t * way);
    while (true) {
      const LeapField::Cube cube = leaps_.template At<leap>(voxel);
      if (Ends(cube.state)) {
        result.state = cube.state;
        result.voxel = first_ + voxel;
        result.at = t;
        return result;
      }
      // The cube's faces ahead, and which of them is met first.
      Vector3i face;
      double exit = kNever;
      int exit_axis = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const int at = voxel[axis] >> cube.bits;
        face[axis] = (way[axis] >= 0.0 ? at + cube.reach : at - cube.reach + 1) << cube.bits;
        const double meets = (face[axis] - from_[axis]) * inverse[axis];
        exit_axis = meets < exit ? axis : exit_axis;
        exit = std::min(exit, meets);
      }
      exit = std::max(exit, t);
      if (Unknown(cube)) result.unknown += std::min(exit, end) - t;
      if (exit >= end) return result;
      t = exit;
      for (int axis = 0; axis < 3; ++axis) {
        // Not past the cube's other faces, nor back, where rounding would have it.
        const int at = static_cast<int>(from_[axis] + t * way[axis]);
        voxel[axis] = way[axis] >= 0.0 ? std::clamp(at, voxel[axis], face[axis] - 1)
                                       : std::clamp(at, face[axis], voxel[axis]);
      }
      voxel[exit_axis] = way[exit_axis] >= 0.0 ? face[exit_axis] : face[exit_axis] - 1;
      if ((voxel.array() < 0).any() || (voxel.array() >= size_.array()).any()) return result;
    }
  }

  /// The directions of a bundle of rays that share their start: the box around them.
  struct Beam {
    Vector3d low;
    Vector3d high;
  };

  /// How far all rays of the beam can be followed as one.
  struct Together {
    double t{};
    double unknown{};
    bool done{};  ///< Nothing ends any of them any more.
  };

  /// Follows the beam from `begin` on while it fits into one cube after the other, up to `end`.
  Together FollowBeam(const Beam& beam, double begin, double end, double unknown) const {
    const Vector3d middle = 0.5 * (beam.low + beam.high);
    const double steepest = middle.cwiseAbs().maxCoeff();
    Vector3d inverse_low;
    Vector3d inverse_high;
    double t = begin;
    double leave = kNever;
    for (int axis = 0; axis < 3; ++axis) {
      inverse_low[axis] = Inverse(beam.low[axis]);
      inverse_high[axis] = Inverse(beam.high[axis]);
      // Some ray may be in the grid's slab between these two.
      if (from_[axis] < 0.0)
        t = std::max(t, beam.high[axis] > 0.0 ? -from_[axis] * inverse_high[axis] : kNever);
      if (from_[axis] > size_[axis]) {
        t = std::max(
            t, beam.low[axis] < 0.0 ? (size_[axis] - from_[axis]) * inverse_low[axis] : kNever);
      }
      if (beam.high[axis] < 0.0) leave = std::min(leave, -from_[axis] * inverse_high[axis]);
      if (beam.low[axis] > 0.0) {
        leave = std::min(leave, (size_[axis] - from_[axis]) * inverse_low[axis]);
      }
    }
    while (true) {
      if (!(t < leave)) return {t, unknown, true};
      if (!(t < end)) return {end, unknown, leap == Leap::kToOccupied};
      // Where it enters the grid its middle may still be out of it.
      const Vector3i voxel = VoxelAround(from_ + t * middle);
      const LeapField::Cube cube = leaps_.template At<leap>(voxel);
      if (Ends(cube.state)) return {t, unknown, false};
      double exit = kNever;
      for (int axis = 0; axis < 3; ++axis) {
        const int at = voxel[axis] >> cube.bits;
        double low = (at - cube.reach + 1) << cube.bits;
        double high = (at + cube.reach) << cube.bits;
        if (Unknown(cube)) {  // out of the grid nothing is unknown
          low = std::max(low, 0.0);
          high = std::min<double>(high, size_[axis]);
        }
        if (from_[axis] + t * beam.low[axis] < low || from_[axis] + t * beam.high[axis] > high) {
          return {t, unknown, false};
        }
        if (beam.high[axis] > 0.0) exit = std::min(exit, (high - from_[axis]) * inverse_high[axis]);
        if (beam.low[axis] < 0.0) exit = std::min(exit, (low - from_[axis]) * inverse_low[axis]);
      }
      exit = std::min(exit, end);
      if (!((exit - t) * steepest > kWorthwhile)) return {t, unknown, false};
      if (Unknown(cube)) unknown += exit - t;
      t = exit;
    }
  }

 private:
  /// The voxel around the point or, when that lies out of the grid, the nearest.
  Vector3i VoxelAround(const Vector3d& at) const {
    return at.cwiseMax(0.0).cast<int>().cwiseMin(size_ - Vector3i::Ones());
  }

  /// A beam that leaps by less than so many voxels is split.
  static constexpr double kWorthwhile = 0.5;

  bool Ends(Occupancy state) const {
    return state == Occupancy::kOccupied ||
           (stop_ == RayStop::kOccupiedOrUnknown && state == Occupancy::kUnknown);
  }

  /// All of the cube is.
  static bool Unknown(const LeapField::Cube& cube) {
    return leap == Leap::kToOther && cube.state == Occupancy::kUnknown;
  }

  const LeapField& leaps_;
  RayStop stop_;
  Vector3i first_;
  Vector3i size_;
  Vector3d from_;
};

template <Leap leap>
RayEnd Cast(const BrickGrid& grid, const LeapField& leaps, const Vector3d& p_WA,
            const Vector3d& p_WB, RayStop stop) {
  return Caster<leap>(grid, leaps, p_WA, stop).Follow((p_WB - p_WA) / grid.voxel(), 0.0, 1.0, 0.0);
}

/// The pixels of a fan, cast in squares.
template <Leap leap>
class FanCaster {
 public:
  FanCaster(const BrickGrid& grid, const LeapField& leaps, const RayFan& fan)
      : caster_(grid, leaps, fan.X_WC.translation(), RayStop::kOccupied),
        fan_(fan),
        ends_(fan.depth.size()) {
    const Eigen::Matrix3d to_voxels = fan.X_WC.linear() / grid.voxel();
    origin_ = to_voxels * fan.camera.Ray(fan.first.x(), fan.first.y());
    per_column_ = to_voxels.col(0) / fan.camera.fx;
    per_row_ = to_voxels.col(1) / fan.camera.fy;
    for (int v = 0; v < fan.size.y(); v += kSquare) {
      for (int u = 0; u < fan.size.x(); u += kSquare) CastSquare(u, v, kSquare, 0.0, 0.0);
    }
  }
  std::vector<RayEnd> ends() && { return std::move(ends_); }

 private:
  static constexpr int kSquare = 16;

  /// The pixels from (u, v) on, which were followed as one up to `begin`.
  void CastSquare(int u, int v, int edge, double begin, double unknown) {
    const int end_u = std::min(u + edge, fan_.size.x());
    const int end_v = std::min(v + edge, fan_.size.y());
    if (u >= end_u || v >= end_v) return;
    if (edge == 1) {
      const std::size_t i = Index(u, v);
      if (!(fan_.depth[i] > 0.0)) return;
      ends_[i] = caster_.Follow(Direction(u, v), begin, fan_.depth[i], unknown);
      return;
    }
    double nearest = kNever;
    double farthest = 0.0;
    for (int row = v; row < end_v; ++row) {
      for (int column = u; column < end_u; ++column) {
        const double depth = fan_.depth[Index(column, row)];
        if (depth > 0.0) nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
      }
    }
    if (farthest == 0.0) return;
    // What is unknown is measured to where each ray ends; what is occupied may be found beyond.
    const double end = leap == Leap::kToOther ? nearest : farthest;
    const Vector3d across = (end_u - 1 - u) * per_column_;
    const Vector3d down = (end_v - 1 - v) * per_row_;
    const Vector3d corner = Direction(u, v);
    const Vector3d zero = Vector3d::Zero();
    const auto together = caster_.FollowBeam({corner + across.cwiseMin(zero) + down.cwiseMin(zero),
                                              corner + across.cwiseMax(zero) + down.cwiseMax(zero)},
                                             begin, end, unknown);
    if (together.done) {
      for (int row = v; row < end_v; ++row) {
        for (int column = u; column < end_u; ++column) {
          RayEnd& result = ends_[Index(column, row)];
          result.at = fan_.depth[Index(column, row)];
          result.unknown = together.unknown;
        }
      }
      return;
    }
    const int half = edge / 2;
    CastSquare(u, v, half, together.t, together.unknown);
    CastSquare(u + half, v, half, together.t, together.unknown);
    CastSquare(u, v + half, half, together.t, together.unknown);
    CastSquare(u + half, v + half, half, together.t, together.unknown);
  }

  std::size_t Index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(fan_.size.x()) +
           static_cast<std::size_t>(u);
  }
  Vector3d Direction(int u, int v) const { return origin_ + u * per_column_ + v * per_row_; }

  Caster<leap> caster_;
  const RayFan& fan_;
  Vector3d origin_;  ///< Of the first pixel, in voxels a metre of depth.
  Vector3d per_column_;
  Vector3d per_row_;
  std::vector<RayEnd> ends_;
};

void Check(const RayFan& fan) {
  if (fan.size.minCoeff() < 0 ||
      fan.depth.size() != static_cast<std::size_t>(fan.size.x()) * fan.size.y()) {
    Throw<InvalidArgument>("ray fan: {} depths for {} x {} pixels", fan.depth.size(), fan.size.x(),
                           fan.size.y());
  }
}

}  // namespace

std::pair<double, double> ShareInside(const Eigen::AlignedBox3d& box, const Vector3d& p_A,
                                      const Vector3d& p_B) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = Inverse(p_B[axis] - p_A[axis]);
    const double a = (box.min()[axis] - p_A[axis]) * inverse;
    const double b = (box.max()[axis] - p_A[axis]) * inverse;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

RayEnd CastRay(const BrickGrid& grid, const LeapField& leaps, const Vector3d& p_WA,
               const Vector3d& p_WB, RayStop stop) {
  if (stop == RayStop::kOccupied) return Cast<Leap::kToOccupied>(grid, leaps, p_WA, p_WB, stop);
  return Cast<Leap::kToOther>(grid, leaps, p_WA, p_WB, stop);
}

RayEnd CastRayThroughUnknown(const BrickGrid& grid, const LeapField& leaps, const Vector3d& p_WA,
                             const Vector3d& p_WB) {
  return Cast<Leap::kToOther>(grid, leaps, p_WA, p_WB, RayStop::kOccupied);
}

std::vector<RayEnd> CastFan(const BrickGrid& grid, const LeapField& leaps, const RayFan& fan) {
  Check(fan);
  return FanCaster<Leap::kToOccupied>(grid, leaps, fan).ends();
}

std::vector<RayEnd> CastFanThroughUnknown(const BrickGrid& grid, const LeapField& leaps,
                                          const RayFan& fan) {
  Check(fan);
  return FanCaster<Leap::kToOther>(grid, leaps, fan).ends();
}

}  // namespace secondlook::world
