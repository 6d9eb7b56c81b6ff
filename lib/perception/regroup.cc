#include "lib/perception/regroup.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "lib/common/parallel.h"
#include "lib/perception/choose_together.h"
#include "lib/perception/cuts.h"
#include "lib/perception/explain.h"
#include "lib/perception/hypothesise.h"

namespace secondlook::perception {
namespace {

using world::Cluster;
using world::Detection;
using world::Hypothesis;

constexpr std::size_t kStride = 7;  // of the points between which a distance is looked for
constexpr float kInFront = 0.01F;   // of what hides something behind it [m]
constexpr int kMostThings = 4;      // in one cluster
constexpr int kLeastPixels = 600;   // of a thing that is cut off
constexpr int kRim = 7;             // what is narrower is the rim of something [px]
constexpr double kTouching = 0.03;  // neighbours [m], as far as the rim between them hides
constexpr double kAcross = 0.12;    // neighbours behind one thing in front [m]
constexpr double kMostOfIt = 0.8;   // of a cluster that is a part of the thing beside it
/// Guesses below this share of the quality that a hypothesis needs are not looked into.
constexpr double kWorth = 0.75;

/// The pieces of `pixels` of at least kLeastPixels; narrow strips, as rims leave them, are none,
/// and folds, where depth cameras see nothing, part none.
std::vector<Cluster> Pieces(const std::vector<int>& pixels, const View& view) {
  const int width = view.camera.width;
  cv::Mat mask(view.depth.size(), CV_8UC1, cv::Scalar(0));
  for (const int pixel : pixels) mask.at<uchar>(pixel / width, pixel % width) = 1;
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cv::Mat::ones(kRim, kRim, CV_8UC1));
  cv::dilate(mask, mask, cv::Mat::ones(2 * kRim + 1, 2 * kRim + 1, CV_8UC1));
  cv::Mat piece_of;
  const int count = cv::connectedComponents(mask, piece_of, 8, CV_32S);
  std::vector<std::vector<int>> pieces(static_cast<std::size_t>(count));
  for (const int pixel : pixels) {
    const int piece = piece_of.at<int>(pixel / width, pixel % width);
    if (piece > 0) pieces[static_cast<std::size_t>(piece)].push_back(pixel);
  }
  std::vector<Cluster> clusters;
  for (std::vector<int>& piece : pieces) {
    if (static_cast<int>(piece.size()) < kLeastPixels) continue;
    clusters.push_back(MakeCluster(std::move(piece), view.depth, view.camera));
  }
  return clusters;
}

std::vector<int> Without(const std::vector<int>& pixels, const std::vector<int>& taken) {
  std::vector<int> left;
  std::set_difference(pixels.begin(), pixels.end(), taken.begin(), taken.end(),
                      std::back_inserter(left));
  return left;
}

std::vector<int> Union(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> all;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

/// A cluster that is recognised beyond doubt.
struct Thing {
  Detection detection;
  int chosen{};

  const Hypothesis& hypothesis() const {
    return detection.hypotheses[static_cast<std::size_t>(chosen)];
  }
};

class Regrouping {
 public:
  Regrouping(const View& view, const std::vector<Cluster>& clusters,
             const std::vector<RecognitionModel>& models, const RecogniseConfig& config)
      : given_(view), models_(models), config_(config) {
    result_.detections = Recognise(view, clusters, models, config);
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      result_.sources.push_back({static_cast<int>(i)});
    }
    Choose();
  }

  Regrouped Run() {
    for (std::size_t i = 0; i < result_.detections.size(); ++i) {
      if (IsUnexplained(i)) CutUp(i);
    }
    Choose();
    JoinNeighbours();
    for (int round = 2; round < kMostThings && SplitOffLeftovers(); ++round) Choose();
    Absorb();
    return std::move(result_);
  }

 private:
  void Choose() { result_.choices = ChooseTogether(result_.detections, models_, config_); }

  const Hypothesis* Chosen(std::size_t i) const {
    const int h = result_.choices[i].hypothesis;
    return h < 0 ? nullptr : &result_.detections[i].hypotheses[static_cast<std::size_t>(h)];
  }

  /// No model is accepted there, not even in doubt.
  bool IsOpen(std::size_t i) const {
    const auto& hypotheses = result_.detections[i].hypotheses;
    return std::none_of(hypotheses.begin(), hypotheses.end(),
                        [](const Hypothesis& h) { return h.verification.accepted; });
  }

  /// No model even comes near to explaining all of it: it has that shape, whatever else fails.
  bool IsUnexplained(std::size_t i) const {
    const auto& hypotheses = result_.detections[i].hypotheses;
    return std::none_of(hypotheses.begin(), hypotheses.end(), [&](const Hypothesis& h) {
      return h.verification.quality >= config_.verify.min_quality;
    });
  }

  /// The view as one of `parts`: to each, all else is what stands in front or behind.
  View ViewOf(const std::vector<Cluster>& parts) const {
    return MakeView(given_.color, given_.depth, given_.camera, given_.plane_C, parts,
                    given_.further_C);
  }

  /// The things that `parts` are: empty where that is not beyond doubt.
  std::vector<std::optional<Thing>> Things(const std::vector<Cluster>& parts) const {
    std::vector<Detection> detections = Recognise(ViewOf(parts), parts, models_, config_);
    const std::vector<Choice> choices = ChooseTogether(detections, models_, config_);
    std::vector<std::optional<Thing>> things(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (choices[k].hypothesis < 0) continue;
      things[k] = Thing{std::move(detections[k]), choices[k].hypothesis};
    }
    return things;
  }

  /// Whether a model may fit one of `parts` well enough to look into.
  bool WorthTrying(const std::vector<Cluster>& parts) const {
    const View view = ViewOf(parts);
    std::vector<char> worth(parts.size() * models_.size(), 0);
    ParallelFor(static_cast<int>(worth.size()), [&](int k) {
      const int part = k / static_cast<int>(models_.size());
      const auto m = static_cast<std::size_t>(k) % models_.size();
      const Cluster& cluster = parts[static_cast<std::size_t>(part)];
      const std::vector<PoseGuess> guesses =
          HypothesisePoses(models_[m], view, part, cluster, OrientCluster(view, part, cluster), 1);
      worth[static_cast<std::size_t>(k)] =
          !guesses.empty() && guesses.front().quality >= kWorth * config_.verify.min_quality;
    });
    return std::count(worth.begin(), worth.end(), 1) > 0;
  }

  /// The pixels of `cluster` that `hypothesis` explains.
  std::vector<int> Explained(const Cluster& cluster, const Hypothesis& hypothesis) const {
    std::vector<Cluster> whole{cluster};
    return TakeExplained(FindModel(models_, hypothesis.model)->mesh, hypothesis.X_CM, given_.depth,
                         given_.camera, 0, &whole)
        .pixels;
  }

  /// Cuts the detection `i` up when all its parts are recognised.
  void CutUp(std::size_t i) {
    const std::vector<Cluster> parts = Decompose(result_.detections[i].cluster, kMostThings);
    if (parts.empty()) return;
    std::vector<std::optional<Thing>> things = Things(parts);
    if (std::any_of(things.begin(), things.end(), [](const auto& thing) { return !thing; })) return;
    result_.detections[i] = std::move(things[0]->detection);
    for (std::size_t k = 1; k < things.size(); ++k) {
      result_.detections.push_back(std::move(things[k]->detection));
      result_.sources.push_back(result_.sources[i]);
    }
  }

  /// Two to `most` parts of `cluster` that each are recognised and explain it together; none when
  /// there are none.
  std::vector<Cluster> Decompose(const Cluster& cluster, int most) const {
    for (const Cut& cut : AllCuts(cluster)) {
      std::vector<Cluster> halves;
      for (const std::vector<int>& pixels : cut) {
        halves.push_back(MakeCluster(pixels, given_.depth, given_.camera));
      }
      if (!WorthTrying(halves)) continue;
      const std::vector<std::optional<Thing>> things = Things(halves);
      const Thing* first = Best(things);
      if (first == nullptr) continue;
      const std::vector<int> taken = Explained(cluster, first->hypothesis());
      std::vector<Cluster> parts{MakeCluster(taken, given_.depth, given_.camera)};
      for (const Cluster& piece : Pieces(Without(cluster.pixels, taken), given_)) {
        if (Things({piece})[0]) {
          parts.push_back(piece);
        } else if (most > 2) {
          for (Cluster& part : Decompose(piece, most - 1)) parts.push_back(std::move(part));
        }
      }
      std::size_t explained = 0;
      for (const Cluster& part : parts) explained += part.pixels.size();
      if (parts.size() > 1 && explained >= LeastExplained(cluster)) return parts;
    }
    return {};
  }

  static const Thing* Best(const std::vector<std::optional<Thing>>& things) {
    const Thing* best = nullptr;
    for (const std::optional<Thing>& thing : things) {
      const auto matching = [](const Thing& t) { return t.hypothesis().verification.matching; };
      if (thing && (best == nullptr || matching(*thing) > matching(*best))) best = &*thing;
    }
    return best;
  }

  std::size_t LeastExplained(const Cluster& cluster) const {
    return static_cast<std::size_t>(config_.verify.min_explained *
                                    static_cast<double>(cluster.pixels.size()));
  }

  std::vector<Cut> AllCuts(const Cluster& cluster) const {
    std::vector<Cut> cuts = CutsByColor(cluster, given_);
    for (Cut& cut : CutsByShape(cluster, given_.PlaneUnder(cluster.center_C)))
      cuts.push_back(std::move(cut));
    std::erase_if(cuts, [](const Cut& cut) {
      return static_cast<int>(std::min(cut[0].size(), cut[1].size())) < kLeastPixels;
    });
    return cuts;
  }

  /// Joins neighbours of which neither is recognised alone when they are recognised together.
  void JoinNeighbours() {
    for (std::size_t i = 0; i < result_.detections.size(); ++i) {
      for (std::size_t j = i + 1; j < result_.detections.size(); ++j) {
        if (Chosen(i) != nullptr || Chosen(j) != nullptr || !(IsOpen(i) || IsOpen(j))) continue;
        const Cluster& a = result_.detections[i].cluster;
        const Cluster& b = result_.detections[j].cluster;
        if (!AreNeighbours(a, b)) continue;
        const Cluster both = MakeCluster(Union(a.pixels, b.pixels), given_.depth, given_.camera);
        if (!WorthTrying({both})) continue;
        std::optional<Thing> whole = Things({both})[0];
        if (!whole || Explained(a, whole->hypothesis()).size() < LeastExplained(a) ||
            Explained(b, whole->hypothesis()).size() < LeastExplained(b)) {
          continue;
        }
        Join(i, j);
        result_.detections[i] = std::move(whole->detection);
        Choose();
        --j;
      }
    }
  }

  /// Whether the two touch, or something in front of both lies between them.
  bool AreNeighbours(const Cluster& a, const Cluster& b) const {
    double nearest = kAcross * kAcross;
    std::array<int, 2> at{-1, -1};
    for (std::size_t i = 0; i < a.points_C.size(); i += kStride) {
      for (std::size_t j = 0; j < b.points_C.size(); j += kStride) {
        const double distance = (a.points_C[i] - b.points_C[j]).squaredNorm();
        if (distance >= nearest) continue;
        nearest = distance;
        at = {a.pixels[i], b.pixels[j]};
      }
    }
    if (at[0] < 0) return false;
    if (nearest < kTouching * kTouching) return true;
    const int width = given_.camera.width;
    const cv::Point from(at[0] % width, at[0] / width);
    const cv::Point to(at[1] % width, at[1] / width);
    const float depth = std::min(given_.depth.at<float>(from), given_.depth.at<float>(to));
    cv::LineIterator line(given_.depth, from, to);
    int nearer = 0;
    for (int k = 0; k < line.count; ++k, ++line) {
      nearer += given_.depth.at<float>(line.pos()) < depth - kInFront ? 1 : 0;
    }
    return nearer > line.count / 2;
  }

  /// Recognises what chosen things leave of their clusters. True when there is one thing more.
  bool SplitOffLeftovers() {
    const std::size_t before = result_.detections.size();
    for (std::size_t i = 0; i < before; ++i) {
      if (Chosen(i) == nullptr) continue;
      const Cluster& whole = result_.detections[i].cluster;
      const std::vector<int> left = Without(whole.pixels, Explained(whole, *Chosen(i)));
      for (const Cluster& piece : Pieces(left, given_)) {
        const Cluster rest =
            MakeCluster(Without(result_.detections[i].cluster.pixels, piece.pixels), given_.depth,
                        given_.camera);
        std::vector<std::optional<Thing>> things = Things({rest, piece});
        if (!things[0] || !things[1]) continue;
        result_.detections[i] = std::move(things[0]->detection);
        result_.detections.push_back(std::move(things[1]->detection));
        result_.sources.push_back(result_.sources[i]);
      }
    }
    return result_.detections.size() > before;
  }

  /// Nothing but the model of `thing` is accepted there.
  bool MayBePartOf(std::size_t j, const Hypothesis& thing) const {
    const auto& hypotheses = result_.detections[j].hypotheses;
    return Chosen(j) == nullptr &&
           std::all_of(hypotheses.begin(), hypotheses.end(), [&](const Hypothesis& h) {
             return !h.verification.accepted || h.model == thing.model;
           });
  }

  /// Gives open clusters that a chosen thing explains to that.
  void Absorb() {
    for (std::size_t i = 0; i < result_.detections.size(); ++i) {
      if (Chosen(i) == nullptr) continue;
      for (std::size_t j = result_.detections.size(); j-- > 0;) {
        if (j == i || !MayBePartOf(j, *Chosen(i))) continue;
        const Cluster& part = result_.detections[j].cluster;
        if (static_cast<double>(Explained(part, *Chosen(i)).size()) <
            kMostOfIt * static_cast<double>(part.pixels.size())) {
          continue;
        }
        Cluster& whole = result_.detections[i].cluster;
        whole = MakeCluster(Union(whole.pixels, part.pixels), given_.depth, given_.camera);
        Join(i, j);
        result_.choices.erase(result_.choices.begin() + static_cast<std::ptrdiff_t>(j));
        if (j < i) --i;
      }
    }
  }

  /// Detection `j` is a part of detection `i`.
  void Join(std::size_t i, std::size_t j) {
    result_.sources[i] = Union(result_.sources[i], result_.sources[j]);
    const auto at = static_cast<std::ptrdiff_t>(j);
    result_.detections.erase(result_.detections.begin() + at);
    result_.sources.erase(result_.sources.begin() + at);
  }

  const View& given_;
  const std::vector<RecognitionModel>& models_;
  const RecogniseConfig& config_;
  Regrouped result_;
};

}  // namespace

Regrouped RecogniseRegrouping(const View& view, const std::vector<Cluster>& clusters,
                              const std::vector<RecognitionModel>& models,
                              const RecogniseConfig& config) {
  return Regrouping(view, clusters, models, config).Run();
}

}  // namespace secondlook::perception
