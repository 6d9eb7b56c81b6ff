#include "lib/perception/ppf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lib/common/error.h"
#include "lib/common/rng.h"

namespace secondlook::perception {
namespace {

using geometry::OrientedPoint;

constexpr int kAngleBins = 15;  // over [0, pi]
constexpr int kTurnBins = 30;   // over [0, 2 pi)
constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kCoplanar = 0.12F;  // [rad]

/// The feature of a pair in units of its cells.
struct Feature {
  std::array<float, 4> value;
  bool coplanar;
};

Feature FeatureOf(const OrientedPoint& a, const OrientedPoint& b, float spacing) {
  const Eigen::Vector3f d = b.point - a.point;
  const float length = d.norm();
  const float inverse = length > 0.0F ? 1.0F / length : 0.0F;
  const auto angle = [](float cosine) { return std::acos(std::clamp(cosine, -1.0F, 1.0F)); };
  const float first = angle(a.normal.dot(d) * inverse);
  const float second = angle(b.normal.dot(d) * inverse);
  const float between = angle(a.normal.dot(b.normal));
  constexpr float kScale = static_cast<float>(kAngleBins) / kPi;
  return {{length / spacing, first * kScale, second * kScale, between * kScale},
          std::abs(first - kPi / 2) < kCoplanar && std::abs(second - kPi / 2) < kCoplanar &&
              between < kCoplanar};
}

int DistanceBins(double sampling) { return static_cast<int>(1.0 / sampling + 1e-6) + 1; }

int CellOf(int distance, int a, int b, int c) {
  return ((distance * kAngleBins + a) * kAngleBins + b) * kAngleBins + c;
}

int AngleCell(float value) { return std::clamp(static_cast<int>(value), 0, kAngleBins - 1); }

/// The motion that brings `a` to the origin with its normal along +x.
Eigen::Isometry3f ToReference(const OrientedPoint& a) {
  Eigen::Isometry3f X = Eigen::Isometry3f::Identity();
  X.linear() =
      Eigen::Quaternionf::FromTwoVectors(a.normal, Eigen::Vector3f::UnitX()).toRotationMatrix();
  X.translation() = -(X.linear() * a.point);
  return X;
}

/// The turn about +x that brings the reference-frame point into the half plane y > 0.
std::uint16_t TurnOf(const Eigen::Vector3f& p) {
  const float turn = -std::atan2(p.z(), p.y());
  return static_cast<std::uint16_t>(
      static_cast<std::int32_t>(std::lround(turn * (32768.0F / kPi))) & 0xffff);
}

/// The cells a feature falls into: its own, and the neighbour on the near side along each of the
/// four where it lies within a fifth of the border. 1 to 16 of them.
int CellsOf(const Feature& feature, int distance_bins, std::array<int, 16>* cells) {
  std::array<std::array<int, 2>, 4> choices;
  std::array<int, 4> count;
  for (std::size_t k = 0; k < 4; ++k) {
    const int limit = k == 0 ? distance_bins : kAngleBins;
    const int own = std::clamp(static_cast<int>(feature.value[k]), 0, limit - 1);
    const float part = feature.value[k] - static_cast<float>(own);
    choices[k][0] = own;
    count[k] = 1;
    const int other = part < 0.2F ? own - 1 : (part > 0.8F ? own + 1 : -1);
    if (other >= 0 && other < limit) choices[k][static_cast<std::size_t>(count[k]++)] = other;
  }
  int found = 0;
  for (int i = 0; i < count[0]; ++i) {
    for (int j = 0; j < count[1]; ++j) {
      for (int k = 0; k < count[2]; ++k) {
        for (int l = 0; l < count[3]; ++l) {
          (*cells)[static_cast<std::size_t>(found++)] = CellOf(
              choices[0][static_cast<std::size_t>(i)], choices[1][static_cast<std::size_t>(j)],
              choices[2][static_cast<std::size_t>(k)], choices[3][static_cast<std::size_t>(l)]);
        }
      }
    }
  }
  return found;
}

/// Of one reference point, by (model point, turn): the votes and the pair that voted last.
struct Cell {
  std::uint16_t votes;
  std::uint16_t last;
};

}  // namespace

std::size_t PpfCellCount(double sampling) {
  return static_cast<std::size_t>(DistanceBins(sampling)) * kAngleBins * kAngleBins * kAngleBins;
}

PpfModel TrainPpf(const geometry::Mesh& mesh, double sampling) {
  if (!(sampling > 0.0 && sampling <= 0.25)) {
    Throw<InvalidArgument>("PPF sampling = {}; it must be in (0, 0.25]", sampling);
  }
  PpfModel model;
  model.diameter = geometry::Diameter(mesh);
  model.spacing = sampling * model.diameter;
  Rng rng(1);
  std::vector<OrientedPoint> drawn;
  // Several for each cell of the grid that thins them.
  const int draws = std::max(6000, static_cast<int>(15.0 / (sampling * sampling)));
  for (const geometry::MeshSample& sample : geometry::SampleSurface(mesh, draws, &rng)) {
    drawn.push_back(sample.surface);
  }
  for (const int i : geometry::SubsampleByNormals(drawn, model.spacing, 0.6)) {
    model.points.push_back(drawn[static_cast<std::size_t>(i)]);
  }
  const auto spacing = static_cast<float>(model.spacing);
  const int distance_bins = DistanceBins(sampling);
  struct Pair {
    int cell;
    PpfModel::Entry entry;
  };
  std::vector<Pair> pairs;
  pairs.reserve(model.points.size() * model.points.size());
  for (std::size_t r = 0; r < model.points.size(); ++r) {
    const Eigen::Isometry3f X = ToReference(model.points[r]);
    for (std::size_t i = 0; i < model.points.size(); ++i) {
      if (i == r) continue;
      const Feature f = FeatureOf(model.points[r], model.points[i], spacing);
      if (f.coplanar) continue;
      const int cell = CellOf(std::min(static_cast<int>(f.value[0]), distance_bins - 1),
                              AngleCell(f.value[1]), AngleCell(f.value[2]), AngleCell(f.value[3]));
      pairs.push_back({cell, {static_cast<std::uint16_t>(r), TurnOf(X * model.points[i].point)}});
    }
  }
  // Counting sort by cell; within a cell the order of the pairs stays.
  model.first.assign(PpfCellCount(sampling) + 1, 0);
  for (const Pair& pair : pairs) ++model.first[static_cast<std::size_t>(pair.cell) + 1];
  for (std::size_t k = 1; k < model.first.size(); ++k) model.first[k] += model.first[k - 1];
  std::vector<std::uint32_t> next(model.first.begin(), model.first.end() - 1);
  model.entries.resize(pairs.size());
  for (const Pair& pair : pairs) {
    model.entries[next[static_cast<std::size_t>(pair.cell)]++] = pair.entry;
  }
  return model;
}

std::vector<PosePeak> VotePpf(const PpfModel& model, const std::vector<OrientedPoint>& scene_C,
                              int stride) {
  std::vector<PosePeak> peaks;
  const auto spacing = static_cast<float>(model.spacing);
  const auto reach = static_cast<float>(model.diameter);
  const int distance_bins =
      static_cast<int>((model.first.size() - 1) / (kAngleBins * kAngleBins * kAngleBins));
  std::vector<Cell> votes_of(model.points.size() * kTurnBins);
  Cell* const cells = votes_of.data();
  const PpfModel::Entry* const entries = model.entries.data();
  for (std::size_t r = 0; r < scene_C.size(); r += static_cast<std::size_t>(stride)) {
    std::fill(votes_of.begin(), votes_of.end(), Cell{0, 0xffff});
    const Eigen::Isometry3f X_RC = ToReference(scene_C[r]);
    for (std::size_t i = 0; i < scene_C.size() && i < 0xffff; ++i) {
      if (i == r || (scene_C[i].point - scene_C[r].point).squaredNorm() > reach * reach) continue;
      const Feature f = FeatureOf(scene_C[r], scene_C[i], spacing);
      if (f.coplanar) continue;
      const std::uint16_t scene_turn = TurnOf(X_RC * scene_C[i].point);
      std::array<int, 16> found;
      const int count = CellsOf(f, distance_bins, &found);
      for (int k = 0; k < count; ++k) {
        const auto cell = static_cast<std::size_t>(found[static_cast<std::size_t>(k)]);
        const PpfModel::Entry* const end = entries + model.first[cell + 1];
        for (const PpfModel::Entry* entry = entries + model.first[cell]; entry != end; ++entry) {
          const auto turn = static_cast<std::uint16_t>(entry->turn - scene_turn);
          const std::size_t bin = (static_cast<std::size_t>(turn) * kTurnBins) >> 16U;
          Cell& votes = cells[entry->reference * std::size_t{kTurnBins} + bin];
          if (votes.last == i) continue;
          votes = {static_cast<std::uint16_t>(votes.votes + 1), static_cast<std::uint16_t>(i)};
        }
      }
    }
    // A peak is a turn bin with the better of its two neighbours; it stands between them by weight.
    struct Peak {
      int votes;
      std::size_t point;
      float turn;
    };
    std::array<Peak, 3> best{};
    for (std::size_t m = 0; m < model.points.size(); ++m) {
      const Cell* row = &cells[m * kTurnBins];
      for (int b = 0; b < kTurnBins; ++b) {
        const int own = row[b].votes;
        const int next = row[(b + 1) % kTurnBins].votes;
        const int votes = own + next;
        if (votes <= best[2].votes) continue;
        const float turn = (static_cast<float>(b) + 0.5F +
                            static_cast<float>(next) / static_cast<float>(std::max(votes, 1))) *
                           2.0F * kPi / kTurnBins;
        const Peak peak{votes, m, turn};
        // One peak a model point: neighbouring bins are the same pose.
        if (best[0].votes > 0 && best[0].point == m) {
          if (votes > best[0].votes) best[0] = peak;
        } else if (votes > best[0].votes) {
          best[2] = best[1];
          best[1] = best[0];
          best[0] = peak;
        } else if (best[1].votes > 0 && best[1].point == m) {
          if (votes > best[1].votes) best[1] = peak;
        } else if (votes > best[1].votes) {
          best[2] = best[1];
          best[1] = peak;
        } else {
          best[2] = peak;
        }
      }
    }
    for (const Peak& peak : best) {
      if (peak.votes < 3 || peak.votes < 0.9 * best[0].votes) continue;
      const Eigen::Isometry3f X_RM = Eigen::AngleAxisf(peak.turn, Eigen::Vector3f::UnitX()) *
                                     ToReference(model.points[peak.point]);
      const Eigen::Isometry3d X_CM = (X_RC.inverse() * X_RM).cast<double>();
      Pose pose = Pose::Identity();
      pose.linear() = Eigen::Quaterniond(X_CM.linear()).normalized().toRotationMatrix();
      pose.translation() = X_CM.translation();
      peaks.push_back({pose, peak.votes});
    }
  }
  return peaks;
}

std::vector<PosePeak> ClusterPeaks(std::vector<PosePeak> peaks, const Symmetry& symmetry,
                                   const Eigen::Vector3d& center_M, double distance, double angle) {
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const PosePeak& a, const PosePeak& b) { return a.votes > b.votes; });
  std::vector<PosePeak> seeds;
  std::vector<int> sums;
  for (const PosePeak& peak : peaks) {
    int nearest = -1;
    double least = 1.0;
    for (std::size_t k = 0; k < seeds.size(); ++k) {
      const PoseDistance d =
          DistanceUpToSymmetry(seeds[k].X_CM, peak.X_CM, symmetry, center_M, false);
      const double measure = std::max(d.translation / distance, d.rotation / angle);
      if (measure < least) {
        least = measure;
        nearest = static_cast<int>(k);
      }
    }
    if (nearest < 0) {
      seeds.push_back(peak);
      sums.push_back(peak.votes);
    } else {
      sums[static_cast<std::size_t>(nearest)] += peak.votes;
    }
  }
  for (std::size_t k = 0; k < seeds.size(); ++k) seeds[k].votes = sums[k];
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const PosePeak& a, const PosePeak& b) { return a.votes > b.votes; });
  return seeds;
}

}  // namespace secondlook::perception
