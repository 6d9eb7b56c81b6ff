#include "lib/perception/refine.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "lib/geometry/point_to_plane.h"
#include "lib/perception/contact.h"

namespace secondlook::perception {
namespace {

using geometry::DepthRasteriser;
using geometry::PixelRect;
using geometry::PointPlanePair;

constexpr double kSurfacePairs = 500.0;
constexpr double kOutlinePixels = 8.0;  // how far an outline is drawn [px]

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

}  // namespace

Pose RefinePose(const RecognitionModel& model, Pose X_CM, const View& view, int label, int rounds,
                DepthRasteriser* rasteriser) {
  std::vector<PointPlanePair> pairs;
  for (int round = 0; round < rounds; ++round) {
    const PixelRect window = geometry::ImageBounds(model.mesh, X_CM, view.camera, 6);
    if (window.empty()) return X_CM;
    rasteriser->Render(model.mesh, X_CM, view.camera, window);
    pairs.clear();
    AddSurfacePairs(model, view, label, *rasteriser, &pairs);
    const auto surface = static_cast<double>(pairs.size());
    AddOutlinePairs(view, label, *rasteriser, 0.3 * surface, &pairs);
    AddContact(model, X_CM, view.plane_C, 0.1 * surface, &pairs);
    X_CM = geometry::SolvePointToPlane(pairs).X * X_CM;
  }
  return X_CM;
}

}  // namespace secondlook::perception
