#include "lib/perception/segment.h"

#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/commands/commands.h"
#include "apps/commands/parse_up.h"
#include "apps/json_output.h"
#include "lib/common/files.h"
#include "lib/geometry/pcd.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;

struct SegmentOptions {
  std::string cloud;
  std::string up;
  std::string json;
};

/// The label of every point of an organised cloud: 0 none, i + 1 for cluster i.
cv::Mat LabelImage(const geometry::PointImage& cloud, const std::vector<world::Cluster>& clusters) {
  cv::Mat labels = cv::Mat::zeros(cloud.height, cloud.width, CV_16U);
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (const int pixel : clusters[i].pixels) {
      labels.at<std::uint16_t>(pixel / cloud.width, pixel % cloud.width) =
          static_cast<std::uint16_t>(i + 1);
    }
  }
  return labels;
}

nlohmann::ordered_json ToJson(const perception::Segmentation& result, const std::string& labels) {
  const auto vector = [](const Eigen::Vector3d& v) {
    return nlohmann::ordered_json{v.x(), v.y(), v.z()};
  };
  nlohmann::ordered_json json;
  json["plane"] = nullptr;
  if (result.plane_C) {
    json["plane"] = {{"normal", vector(result.plane_C->normal_A)},
                     {"offset", result.plane_C->offset}};
  }
  json["clusters"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < result.clusters.size(); ++i) {
    const world::Cluster& cluster = result.clusters[i];
    json["clusters"].push_back({{"points", cluster.pixels.size()},
                                {"center", vector(cluster.center_C)},
                                {"plane", result.stands_on[i]}});
  }
  json["labels"] = labels;
  json["reason"] = result.reason;
  json["planes"] = PlanesToJson(result.Planes());
  return json;
}

void PrintTable(const perception::Segmentation& result) {
  for (const world::SupportPlane& plane : result.Planes()) {
    const Eigen::Vector3d& n = plane.normal_A;
    fmt::print("support plane: normal ({:.3f}, {:.3f}, {:.3f}), offset {:.3f} m, {} points\n",
               n.x(), n.y(), n.z(), plane.offset, plane.inliers);
  }
  for (std::size_t i = 0; i < result.clusters.size(); ++i) {
    const Eigen::Vector3d& p = result.clusters[i].center_C;
    fmt::print("cluster {:2}: {:6} points around ({:.3f}, {:.3f}, {:.3f}) m\n", i + 1,
               result.clusters[i].pixels.size(), p.x(), p.y(), p.z());
  }
  if (!result.reason.empty()) fmt::print("{}\n", result.reason);
}

/// Where the label image goes: beside the JSON file, or beside the working folder's cloud name.
fs::path LabelFile(const SegmentOptions& options) {
  const fs::path name = fs::path(options.cloud).stem().string() + "-labels.png";
  const bool to_file = !options.json.empty() && options.json != "-";
  return to_file ? fs::path(options.json).parent_path() / name : name;
}

void Segment(const SegmentOptions& options) {
  const geometry::PointImage cloud = geometry::ReadPcd(options.cloud);
  perception::SegmentConfig config;
  Eigen::Vector3d up_C = kImageUp_C;
  if (options.up.empty()) {
    config.max_tilt_deg = kImageUpTolerance_deg;
    spdlog::info("no --up given: up is taken to lie within {} deg of image-up",
                 kImageUpTolerance_deg);
  } else {
    up_C = ParseUp(options.up);
  }
  const perception::Segmentation result = perception::Segment(cloud, up_C, config);

  std::string labels;
  if (cloud.organised()) {
    const fs::path file = LabelFile(options);
    std::vector<unsigned char> png;
    cv::imencode(".png", LabelImage(cloud, result.clusters), png);
    WriteFile(file, {reinterpret_cast<const char*>(png.data()), png.size()});
    labels = file.string();
  }
  if (options.json != "-") PrintTable(result);
  if (!options.json.empty()) WriteJson(ToJson(result, labels), options.json);
}

}  // namespace

void AddSegment(CLI::App* app, int*) {
  CLI::App* segment =
      app->add_subcommand("segment", "Cuts a point cloud into support plane and things");
  const auto options = std::make_shared<SegmentOptions>();  // outlives this function in callbacks
  segment->add_option("--cloud", options->cloud, "Point cloud, PCD, metres")->required();
  segment->add_option("--up", options->up, "Direction against gravity in the camera frame: x,y,z");
  segment->add_option("--json", options->json, "Result as JSON; - is standard output");
  segment->callback([options] { Segment(*options); });
}

}  // namespace secondlook::apps
