#include "lib/world/bayes_update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "lib/common/error.h"

namespace secondlook::world {
namespace {

using Eigen::Array3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

/// What one image says of the voxels in a box of whole bricks: two bytes each, x running fastest.
/// Positions are in voxels from the box's lowest corner.
struct Marks {
  Marks(const Vector3i& first_brick, const Vector3i& brick_count)
      : first(first_brick),
        count(brick_count),
        size(brick_count * Brick::kEdge),
        passed(static_cast<std::size_t>(size.prod()), 0),
        ended(passed.size(), 0) {}

  std::ptrdiff_t Stride(int axis) const {
    return axis == 0 ? 1 : axis == 1 ? size.x() : size.x() * size.y();
  }
  std::ptrdiff_t IndexOf(const Vector3i& voxel) const {
    return voxel.x() + voxel.y() * Stride(1) + voxel.z() * Stride(2);
  }

  Vector3i first;                    ///< In bricks.
  Vector3i count;                    ///< In bricks.
  Vector3i size;                     ///< In voxels.
  std::vector<std::uint8_t> passed;  ///< 1: by a ray.
  std::vector<std::uint8_t> ended;   ///< kHit, kCutOff: by a ray that ends there; 0: none.
};

constexpr std::uint8_t kHit = 1;
constexpr std::uint8_t kCutOff = 2;

/// Which part of the way from `from` along `way`, in lengths of it, lies in the box from 0 to
/// `size`; first > second: none.
inline std::pair<double, double> Inside(const Vector3d& from, const Vector3d& way,
                                        const Vector3i& size) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (way[axis] == 0.0) {
      if (from[axis] < 0.0 || from[axis] >= size[axis]) return {1.0, 0.0};
      continue;
    }
    const double a = -from[axis] / way[axis];
    const double b = (size[axis] - from[axis]) / way[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

/// The voxel around `at`, which lies in the box but for rounding.
inline Vector3i VoxelAround(const Vector3d& at, const Vector3i& size) {
  return at.cwiseMax(0.0).cast<int>().cwiseMin(size - Vector3i::Ones());
}

/// Positions with 24 bits for the part of a voxel.
using Fixed = std::int64_t;
constexpr int kFraction = 24;
Fixed ToFixed(double position) {
  return static_cast<Fixed>(position * (std::int64_t{1} << kFraction));
}

/// Marks as passed the voxels on the straight line from `from` to the centre of `to`, the latter
/// included. The line crosses the voxels in layers along the axis it is steepest in, and moves by
/// at most one voxel a layer along the two others, a and b. So it meets up to three voxels in each:
/// where it enters, where it leaves, and one between, by which of the two faces comes first. All
/// three are marked, the same or not: a branch would cost more (Amanatides and Woo 1987 take one a
/// voxel).
void MarkPassed(const Vector3d& from, const Vector3i& to, Marks* marks) {
  const Vector3d center = to.cast<double>() + Vector3d::Constant(0.5);
  const Vector3d way = center - from;
  const Vector3d start = from + Inside(from, way, marks->size).first * way;
  const Vector3i begin = VoxelAround(start, marks->size);
  int axis = 0;
  const Vector3d step = way / way.cwiseAbs().maxCoeff(&axis);
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  const bool up = way[axis] > 0.0;
  const double to_face = up ? begin[axis] + 1 - start[axis] : start[axis] - begin[axis];
  const int faces = std::abs(to[axis] - begin[axis]);

  const Fixed last_a = marks->size[a] - 1;
  const Fixed last_b = marks->size[b] - 1;
  const Fixed step_a = ToFixed(step[a]);
  const Fixed step_b = ToFixed(step[b]);
  const Fixed steep_a = std::abs(step_a);
  const Fixed steep_b = std::abs(step_b);
  const std::ptrdiff_t stride_a = marks->Stride(a);
  const std::ptrdiff_t stride_b = marks->Stride(b);
  const std::ptrdiff_t stride = up ? marks->Stride(axis) : -marks->Stride(axis);
  std::uint8_t* layer = &marks->passed[begin[axis] * marks->Stride(axis)];
  Fixed p_a = ToFixed(start[a]);  // where the line enters the layer, …
  Fixed p_b = ToFixed(start[b]);
  Fixed in_a = begin[a];  // … in which voxel
  Fixed in_b = begin[b];
  std::ptrdiff_t enters_a = in_a * stride_a;  // … and how far that lies from the layer's corner
  std::ptrdiff_t enters_b = in_b * stride_b;
  Fixed next_a = ToFixed(start[a] + to_face * step[a]);  // where it leaves
  Fixed next_b = ToFixed(start[b] + to_face * step[b]);
  for (int i = 0; i <= faces; ++i) {
    if (i == faces) {
      next_a = ToFixed(center[a]);
      next_b = ToFixed(center[b]);
    }
    const Fixed out_a = std::clamp<Fixed>(next_a >> kFraction, 0, last_a);
    const Fixed out_b = std::clamp<Fixed>(next_b >> kFraction, 0, last_b);
    // To the faces between, where there are any, in a unit of time that both share.
    const Fixed to_a = std::abs((std::max(in_a, out_a) << kFraction) - p_a) * steep_b;
    const Fixed to_b = std::abs((std::max(in_b, out_b) << kFraction) - p_b) * steep_a;
    const Fixed a_first = (to_a - to_b) >> 63;  // all bits or none
    const std::ptrdiff_t leaves_a = out_a * stride_a;
    const std::ptrdiff_t leaves_b = out_b * stride_b;
    const std::ptrdiff_t between_a = enters_a + ((leaves_a - enters_a) & a_first);
    const std::ptrdiff_t between_b = leaves_b + ((enters_b - leaves_b) & a_first);
    layer[enters_a + enters_b] = 1;
    layer[between_a + between_b] = 1;
    layer[leaves_a + leaves_b] = 1;
    layer += stride;
    p_a = next_a;
    p_b = next_b;
    in_a = out_a;
    in_b = out_b;
    enters_a = leaves_a;
    enters_b = leaves_b;
    next_a += step_a;
    next_b += step_b;
  }
}

/// Where the ray of a pixel ends.
struct End {
  Vector3i voxel;  ///< From the grid's first.
  bool hit{};      ///< A surface ends it; false: the grid's end or the range.
};

/// The ends of all rays that meet the grid, those of neighbours in one voxel once.
std::vector<End> Ends(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
                      const DepthUpdate& update, const BrickGrid& grid) {
  const Vector3i size = grid.brick_count() * Brick::kEdge;
  const Vector3d from = X_WC.translation() / grid.voxel() - grid.first_key().cast<double>();
  const Eigen::Matrix3d to_voxels = X_WC.linear() / grid.voxel();
  const Vector3d per_column = to_voxels.col(0) / camera.fx;
  const Array3d top = size.cast<double>();
  const double max_range = update.max_range_m / grid.voxel();
  const double none = std::numeric_limits<double>::infinity();
  std::vector<End> ends;
  for (int v = 0; v < depth.rows; v += update.stride) {
    const auto* row = depth.ptr<float>(v);
    const Vector3d row_start = to_voxels * camera.Ray(0, v);
    for (int u = 0; u < depth.cols; u += update.stride) {
      double z = row[u];
      if (!(z > 0.0) || z == none) {
        if (update.no_return == NoReturn::kNothing) continue;
        z = none;
      }
      const Vector3d direction = row_start + u * per_column;  // 1 along the optical axis
      const bool in_range = z * z * direction.squaredNorm() <= max_range * max_range;
      const Vector3d way = (in_range ? z : max_range / direction.norm()) * direction;
      Array3d end = from + way;
      const bool in_grid = (end >= 0.0).all() && (end < top).all();
      if (!in_grid) {
        const auto [enter, leave] = Inside(from, way, size);
        if (enter >= leave) continue;
        end = from + leave * way;
      }
      const End found{VoxelAround(end, size), in_range && in_grid};
      if (ends.empty() || ends.back().voxel != found.voxel || ends.back().hit != found.hit) {
        ends.push_back(found);
      }
    }
  }
  return ends;
}

/// What a hit and a miss add to the log-odds, and their limits.
struct Increments {
  float hit;
  float miss;
  float min;
  float max;
};

/// Applies marks to one brick.
class BrickUpdate {
 public:
  BrickUpdate(const Increments& increments, Brick* brick)
      : increments_(increments), brick_(brick) {}

  /// Eight voxels from `index` on.
  void Row(const std::uint8_t* passed, const std::uint8_t* ended, int index) {
    for (int x = 0; x < Brick::kEdge; ++x) {
      if (passed[x] == 0) continue;
      const float step = (ended[x] & kHit) != 0 ? increments_.hit : increments_.miss;
      float& log_odds = brick_->log_odds[index + x];
      const float updated = std::clamp(log_odds + step, increments_.min, increments_.max);
      const std::uint64_t bit = std::uint64_t{1} << ((index + x) & 63);
      std::uint64_t& known = brick_->known[index >> 6];
      std::uint64_t& hit = brick_->hit[index >> 6];
      const bool new_state = (known & bit) == 0 || ((hit & bit) != 0) != (updated >= 0.0F);
      value_changed_ |= updated != log_odds;
      state_changed_ |= new_state;
      log_odds = updated;
      known |= bit;
      hit = updated >= 0.0F ? hit | bit : hit & ~bit;
    }
  }
  bool value_changed() const { return value_changed_ || state_changed_; }
  bool state_changed() const { return state_changed_; }

 private:
  Increments increments_;
  Brick* brick_;
  bool value_changed_{};
  bool state_changed_{};
};

/// Applies all marks. Returns how many bricks changed.
int Apply(const Marks& marks, const Increments& increments, BrickGrid* grid) {
  grid->BeginChange();
  int changed = 0;
  for (int i = 0; i < marks.count.prod(); ++i) {
    const Vector3i at(i % marks.count.x(), i / marks.count.x() % marks.count.y(),
                      i / (marks.count.x() * marks.count.y()));
    Brick* brick = nullptr;
    std::optional<BrickUpdate> update;
    for (int row = 0; row < 64; ++row) {
      const std::ptrdiff_t index =
          marks.IndexOf(Brick::kEdge * at + Vector3i(0, row & 7, row >> 3));
      std::uint64_t any;  // of the eight voxels of a row
      std::memcpy(&any, &marks.passed[index], sizeof any);
      if (any == 0) continue;
      if (!update) {
        brick = grid->Touch(grid->DirectoryIndex(marks.first + at));
        update.emplace(increments, brick);
      }
      update->Row(&marks.passed[index], &marks.ended[index], Brick::kEdge * row);
    }
    if (!update || !update->value_changed()) continue;
    ++changed;
    if (update->state_changed()) {
      grid->NoteStates(brick);
    } else {
      grid->NoteValues(brick);
    }
  }
  return changed;
}

void Check(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
           const DepthUpdate& update) {
  if (depth.type() != CV_32FC1 || depth.cols != camera.width || depth.rows != camera.height) {
    Throw<InvalidArgument>(
        "voxel space: the depth image is {} x {} px of OpenCV type {}; the camera's is {} x {} px "
        "of type {} (CV_32FC1)",
        depth.cols, depth.rows, depth.type(), camera.width, camera.height, CV_32FC1);
  }
  if (!IsValid(X_WC)) {
    Throw<InvalidArgument>("voxel space: the camera pose X_WC is not finite and rigid");
  }
  if (update.stride < 1) {
    Throw<InvalidArgument>("voxel space: stride = {} must be at least 1", update.stride);
  }
  if (!(update.max_range_m > 0.0) || !std::isfinite(update.max_range_m)) {
    Throw<InvalidArgument>("voxel space: the range {} m must be positive and finite",
                           update.max_range_m);
  }
  const OccupancyModel& model = update.model;
  if (!(0.0 < model.min_probability && model.min_probability < 0.5 &&
        0.0 < model.miss_probability && model.miss_probability < 0.5 &&
        0.5 < model.hit_probability && model.hit_probability < 1.0 && 0.5 < model.max_probability &&
        model.max_probability < 1.0)) {
    Throw<InvalidArgument>(
        "voxel space: probabilities of a miss {} and hit {}, limits {} and {}; the first of each "
        "pair must lie in 0..0.5, the second in 0.5..1",
        model.miss_probability, model.hit_probability, model.min_probability,
        model.max_probability);
  }
}

}  // namespace

int EnterDepth(const cv::Mat& depth, const geometry::CameraModel& camera, const Pose& X_WC,
               const DepthUpdate& update, BrickGrid* grid) {
  Check(depth, camera, X_WC, update);
  const std::vector<End> ends = Ends(depth, camera, X_WC, update, *grid);
  if (ends.empty()) return 0;

  // The rays lie in the box around the ends and where they come from, as far as the grid reaches.
  const Vector3d from = X_WC.translation() / grid->voxel() - grid->first_key().cast<double>();
  Vector3i low = VoxelAround(from, grid->brick_count() * Brick::kEdge);
  Vector3i high = low;
  for (const End& end : ends) {
    low = low.cwiseMin(end.voxel);
    high = high.cwiseMax(end.voxel);
  }
  const auto brick = [](int voxel) { return voxel >> Brick::kBits; };
  const Vector3i first = low.unaryExpr(brick);
  Marks marks(grid->first_brick() + first, high.unaryExpr(brick) - first + Vector3i::Ones());
  const Vector3i origin = first * Brick::kEdge;
  for (const End& end : ends) {
    const Vector3i to = end.voxel - origin;
    std::uint8_t& ended = marks.ended[marks.IndexOf(to)];
    if (ended == 0) MarkPassed(from - origin.cast<double>(), to, &marks);
    ended |= end.hit ? kHit : kCutOff;
  }
  const OccupancyModel& model = update.model;
  return Apply(marks,
               {LogOdds(model.hit_probability), LogOdds(model.miss_probability),
                LogOdds(model.min_probability), LogOdds(model.max_probability)},
               grid);
}

}  // namespace secondlook::world
