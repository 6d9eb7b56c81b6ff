#include "lib/world/scan_patches.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include <Eigen/Eigenvalues>

#include "lib/common/error.h"

namespace secondlook::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The extent across a line, as a share of that along it (variances), below which it is a wire.
constexpr double kWire = 0.02;

/// A cell's place as a number; cells side by side along an axis differ by that axis's step.
using CellKey = std::int64_t;
constexpr int kBits = 21;
constexpr CellKey kHalf = CellKey{1} << (kBits - 1);
constexpr std::array<CellKey, 3> kStep = {1, CellKey{1} << kBits, CellKey{1} << 2 * kBits};

CellKey KeyOf(const Vector3d& p_W, double cell) {
  const Eigen::Array3d at = (p_W / cell).array().floor();
  if (!(at.abs().maxCoeff() < static_cast<double>(kHalf))) {
    Throw<InvalidArgument>(
        "range scan: a point at ({}, {}, {}) m is too far away for cells of {} m", p_W.x(), p_W.y(),
        p_W.z(), cell);
  }
  CellKey key = 0;
  for (int axis = 0; axis < 3; ++axis)
    key += kStep[axis] * (static_cast<CellKey>(at[axis]) + kHalf);
  return key;
}

/// What is summed over the points of a cell, about the scan's first point.
struct Sums {
  double count{};
  Vector3d point{Vector3d::Zero()};
  Matrix3d square{Matrix3d::Zero()};
  Vector3d to_sensor{Vector3d::Zero()};
  double sigma{};

  void Add(const Sums& other) {
    count += other.count;
    point += other.point;
    square += other.square;
    to_sensor += other.to_sensor;
  }
};

Vector3d NormalOf(const Sums& sums) {
  const Vector3d to_sensor = sums.to_sensor.normalized();
  if (sums.count < 3.0) return to_sensor;
  const Vector3d mean = sums.point / sums.count;
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(sums.square / sums.count - mean * mean.transpose());
  const Vector3d along = eigen.eigenvectors().col(2);
  if (!(eigen.eigenvalues()[1] > kWire * eigen.eigenvalues()[2])) {
    const Vector3d across = to_sensor - along * along.dot(to_sensor);
    return across.norm() > 1e-3 ? across.normalized() : to_sensor;
  }
  const Vector3d normal = eigen.eigenvectors().col(0).normalized();
  return normal.dot(to_sensor) < 0.0 ? Vector3d(-normal) : normal;
}

}  // namespace

ScanPatches CutIntoPatches(const RangeScan& scan, double cell) {
  Check(scan);
  if (!(cell > 0.0)) Throw<InvalidArgument>("range scan: patches of {} m", cell);
  ScanPatches result;
  if (scan.empty()) return result;

  std::vector<std::pair<CellKey, int>> points;
  points.reserve(scan.points_W.size());
  for (std::size_t i = 0; i < scan.points_W.size(); ++i) {
    points.emplace_back(KeyOf(scan.points_W[i], cell), static_cast<int>(i));
  }
  std::vector<Vector3d> sensor_W;
  sensor_W.reserve(points.size());
  for (const RangeLine& line : scan.lines) sensor_W.resize(line.end, line.p_WS);
  std::sort(points.begin(), points.end());

  const Vector3d origin_W = scan.points_W.front();
  std::vector<CellKey> keys;
  std::vector<Sums> cells;
  result.of_point.resize(points.size());
  for (const auto& [key, i] : points) {
    if (keys.empty() || keys.back() != key) {
      keys.push_back(key);
      cells.emplace_back();
    }
    const Vector3d p = scan.points_W[i] - origin_W;
    Sums& sums = cells.back();
    sums.count += 1.0;
    sums.point += p;
    sums.square += p * p.transpose();
    sums.to_sensor += (sensor_W[i] - scan.points_W[i]).normalized();
    sums.sigma += scan.sigmas[i];
    result.of_point[i] = static_cast<int>(cells.size()) - 1;
  }
  result.patches.reserve(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    Sums around = cells[c];
    for (const CellKey step : kStep) {
      for (const CellKey beside : {keys[c] - step, keys[c] + step}) {
        const auto found = std::lower_bound(keys.begin(), keys.end(), beside);
        if (found != keys.end() && *found == beside) around.Add(cells[found - keys.begin()]);
      }
    }
    result.patches.push_back({origin_W + cells[c].point / cells[c].count, NormalOf(around),
                              cells[c].sigma / cells[c].count});
  }
  return result;
}

}  // namespace secondlook::world
