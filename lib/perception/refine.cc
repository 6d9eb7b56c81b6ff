#include "lib/perception/refine.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "lib/geometry/point_to_plane.h"
#include "lib/perception/color_match.h"
#include "lib/perception/contact.h"
#include "lib/perception/rendered_colors.h"

namespace secondlook::perception {
namespace {

using geometry::DepthRasteriser;
using geometry::PixelRect;
using geometry::PointPlanePair;

constexpr double kSurfacePairs = 500.0;
constexpr double kOutlinePixels = 8.0;  // how far an outline is drawn [px]
/// What contact weighs, of all surface pairs: in one view, and in several, whose colours outweigh
/// the surface.
constexpr double kContactShare = 0.1;
constexpr double kJointContactShare = 1.0;

double Cauchy(double residual, double scale) {
  const double e = residual / scale;
  return 1.0 / (1.0 + e * e);
}

void AddSurfacePairs(const RecognitionModel& model, const View& view, int label,
                     const DepthRasteriser& rendered, std::vector<PointPlanePair>* pairs) {
  const PixelRect& window = rendered.window();
  const int step = std::max(1, static_cast<int>(std::sqrt(window.area() / kSurfacePairs)));
  for (int y = 0; y < window.height; y += step) {
    const float* measured = view.depth.ptr<float>(window.y + y) + window.x;
    const int* labels = view.labels.ptr<int>(window.y + y) + window.x;
    for (int x = 0; x < window.width; x += step) {
      const int at = y * window.width + x;
      const double z = rendered.depth()[static_cast<std::size_t>(at)];
      const double gate = 1.5 * DepthTolerance(z);
      if (labels[x] != label || !(std::abs(measured[x] - z) < gate)) continue;
      const Eigen::Vector3d ray = view.camera.Ray(window.x + x, window.y + y);
      const Eigen::Vector3d normal = rendered.Normal(model.mesh, at).cast<double>();
      // A slanted surface is uncertain by what one pixel makes of its depth.
      const double slant = -normal.dot(ray) / ray.norm();
      if (slant < 0.15) continue;
      const double residual = normal.dot(ray) * (measured[x] - z);
      pairs->push_back({ray * z, ray * measured[x], normal,
                        slant * Cauchy(residual, geometry::DepthSigma(z) + 0.002)});
    }
  }
}

/// Pairs in the image: outline points of the rendered silhouette toward cluster pixels it misses,
/// and from silhouette pixels seen through back to the cluster.
void AddOutlinePairs(const View& view, int label, const DepthRasteriser& rendered, double weight,
                     std::vector<PointPlanePair>* pairs) {
  const PixelRect& window = rendered.window();
  cv::Mat off_model(window.height, window.width, CV_8UC1);
  cv::Mat off_cluster(window.height, window.width, CV_8UC1);
  for (int y = 0; y < window.height; ++y) {
    const int* labels = view.labels.ptr<int>(window.y + y) + window.x;
    for (int x = 0; x < window.width; ++x) {
      const auto at = static_cast<std::size_t>(y * window.width + x);
      off_model.at<uchar>(y, x) = std::isnan(rendered.depth()[at]) ? 1 : 0;
      off_cluster.at<uchar>(y, x) = labels[x] == label ? 0 : 1;
    }
  }
  // By pixel: which pixel of the other set is nearest, and how far.
  const auto nearest = [](const cv::Mat& outside, cv::Mat* distance, std::vector<cv::Point>* of) {
    cv::Mat index;
    cv::distanceTransform(outside, *distance, index, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
    of->assign(static_cast<std::size_t>(outside.rows * outside.cols + 1), {-1, -1});
    for (int y = 0; y < outside.rows; ++y) {
      for (int x = 0; x < outside.cols; ++x) {
        if (outside.at<uchar>(y, x) == 0) {
          (*of)[static_cast<std::size_t>(index.at<int>(y, x))] = {x, y};
        }
      }
    }
    return index;
  };
  cv::Mat model_distance;
  cv::Mat cluster_distance;
  std::vector<cv::Point> model_pixel;
  std::vector<cv::Point> cluster_pixel;
  const cv::Mat model_index = nearest(off_model, &model_distance, &model_pixel);
  const cv::Mat cluster_index = nearest(off_cluster, &cluster_distance, &cluster_pixel);

  const std::size_t first = pairs->size();
  const auto pull = [&](const cv::Point& from, const cv::Point& to) {
    const double z = rendered.depth()[static_cast<std::size_t>(from.y * window.width + from.x)];
    if (!(z > 0.0)) return;
    const Eigen::Vector3d p = view.camera.Ray(window.x + from.x, window.y + from.y) * z;
    const Eigen::Vector3d q = view.camera.Ray(window.x + to.x, window.y + to.y) * z;
    const double length = (q - p).norm();
    if (length < 1e-9) return;
    pairs->push_back({p, q, (q - p) / length, Cauchy(length, 3.0 * z / view.camera.fx)});
  };
  for (int y = 0; y < window.height; y += 2) {
    const float* measured = view.depth.ptr<float>(window.y + y) + window.x;
    for (int x = 0; x < window.width; x += 2) {
      const bool on_model = off_model.at<uchar>(y, x) == 0;
      const bool on_cluster = off_cluster.at<uchar>(y, x) == 0;
      if (on_cluster && !on_model && model_distance.at<float>(y, x) < kOutlinePixels) {
        pull(model_pixel[static_cast<std::size_t>(model_index.at<int>(y, x))], {x, y});
      } else if (on_model && !on_cluster && cluster_distance.at<float>(y, x) < kOutlinePixels) {
        const double z = rendered.depth()[static_cast<std::size_t>(y * window.width + x)];
        const bool through = measured[x] > z + DepthTolerance(z);
        if (through) {
          pull({x, y}, cluster_pixel[static_cast<std::size_t>(cluster_index.at<int>(y, x))]);
        }
      }
    }
  }
  double sum = 0.0;
  for (std::size_t i = first; i < pairs->size(); ++i) sum += (*pairs)[i].weight;
  if (sum <= weight) return;
  for (std::size_t i = first; i < pairs->size(); ++i) (*pairs)[i].weight *= weight / sum;
}

/// Pairs along the gradient of the rendered tones, three for each pixel that is not hidden.
void AddColorPairs(const RecognitionModel& model, const View& view, const DepthRasteriser& rendered,
                   std::vector<PointPlanePair>* pairs) {
  constexpr double kPixels = 2500.0;
  constexpr double kToneNoise = 0.5;
  if (view.color.empty()) return;
  const PixelRect& window = rendered.window();
  const RenderedColors colors(model.mesh, rendered);
  const int step = std::max(1, static_cast<int>(std::sqrt(window.area() / kPixels)));
  std::vector<ColorPair> seen;
  std::vector<cv::Point> pixels;
  for (int y = 2; y + 2 < window.height; y += step) {
    for (int x = 2; x + 2 < window.width; x += step) {
      const bool gradient = colors.Mean(x, y) && colors.Mean(x - 1, y) && colors.Mean(x + 1, y) &&
                            colors.Mean(x, y - 1) && colors.Mean(x, y + 1);
      if (!gradient) continue;
      const int at = y * window.width + x;
      const double z = rendered.depth()[static_cast<std::size_t>(at)];
      const double measured = view.depth.at<float>(window.y + y, window.x + x);
      if (std::abs(measured - z) > DepthTolerance(z)) continue;  // NaN passes: dark or shiny
      seen.push_back({MeanColor(view.color, window.x + x, window.y + y), *colors.Mean(x, y),
                      rendered.Normal(model.mesh, at)});
      pixels.emplace_back(x, y);
    }
  }
  if (seen.size() < 20) return;
  const std::vector<Eigen::Vector3d> differences = ToneDifferences(seen);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto& [x, y] = std::pair(pixels[i].x, pixels[i].y);
    const double z = rendered.depth()[static_cast<std::size_t>(y * window.width + x)];
    const Eigen::Vector3d ray = view.camera.Ray(window.x + x, window.y + y);
    const Eigen::Vector3d du =
        0.5 * (ToneOf(*colors.Mean(x + 1, y)) - ToneOf(*colors.Mean(x - 1, y)));
    const Eigen::Vector3d dv =
        0.5 * (ToneOf(*colors.Mean(x, y + 1)) - ToneOf(*colors.Mean(x, y - 1)));
    const double depth_noise = geometry::DepthSigma(z) + 0.002;
    for (int tone = 0; tone < 3; ++tone) {
      // By how much the tone at this pixel falls as the surface point moves in C [1/m].
      const Eigen::Vector3d slope =
          du[tone] * view.camera.fx / z * Eigen::Vector3d(1.0, 0.0, -ray.x()) +
          dv[tone] * view.camera.fy / z * Eigen::Vector3d(0.0, 1.0, -ray.y());
      const double steepness = slope.norm();
      if (steepness < 1.0) continue;
      const Eigen::Vector3d direction = slope / steepness;
      const double difference = differences[i][tone];
      const double share = steepness * depth_noise / kToneNoise;
      pairs->push_back({ray * z, ray * z - direction * (difference / steepness), direction,
                        share * share * Cauchy(difference, kToneNoise)});
    }
  }
}

/// All that holds the model at X_CM in a view; depth, outline and contact in the proportions of
/// RefinePose().
void AddPairs(const RecognitionModel& model, const Pose& X_CM, const View& view, int label,
              const DepthRasteriser& rendered, double contact_share,
              std::vector<PointPlanePair>* pairs) {
  AddSurfacePairs(model, view, label, rendered, pairs);
  const auto surface = static_cast<double>(pairs->size());
  AddOutlinePairs(view, label, rendered, 0.3 * surface, pairs);
  AddContact(model, X_CM, view.PlaneUnder(X_CM * model.center_M), contact_share * surface, pairs);
}

}  // namespace

Pose RefinePose(const RecognitionModel& model, Pose X_CM, const View& view, int label, int rounds,
                DepthRasteriser* rasteriser) {
  std::vector<PointPlanePair> pairs;
  for (int round = 0; round < rounds; ++round) {
    const PixelRect window = geometry::ImageBounds(model.mesh, X_CM, view.camera, 6);
    if (window.empty()) return X_CM;
    rasteriser->Render(model.mesh, X_CM, view.camera, window);
    pairs.clear();
    AddPairs(model, X_CM, view, label, *rasteriser, kContactShare, &pairs);
    X_CM = geometry::SolvePointToPlane(pairs).X * X_CM;
  }
  return X_CM;
}

Pose RefineTogether(const RecognitionModel& model, std::vector<PlacedModel> placed, int rounds,
                    DepthRasteriser* rasteriser) {
  Pose X_MS = Pose::Identity();
  std::vector<PointPlanePair> pairs_C;
  std::vector<PointPlanePair> pairs_M;
  for (int round = 0; round < rounds; ++round) {
    pairs_M.clear();
    for (const PlacedModel& p : placed) {
      const Pose X_CM = p.X_CM * X_MS;
      const PixelRect window = geometry::ImageBounds(model.mesh, X_CM, p.view->camera, 6);
      if (window.empty()) continue;
      rasteriser->Render(model.mesh, X_CM, p.view->camera, window);
      pairs_C.clear();
      AddPairs(model, X_CM, *p.view, p.label, *rasteriser, kJointContactShare, &pairs_C);
      AddColorPairs(model, *p.view, *rasteriser, &pairs_C);
      const Pose X_MC = X_CM.inverse();
      for (const PointPlanePair& pair : pairs_C) {
        pairs_M.push_back(
            {X_MC * pair.p_AP, X_MC * pair.p_AQ, X_MC.linear() * pair.normal_A, pair.weight});
      }
    }
    X_MS = X_MS * geometry::SolvePointToPlane(pairs_M).X;
  }
  return X_MS;
}

}  // namespace secondlook::perception
