#include "lib/perception/recognise_frame.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "apps/commands/parse_up.h"
#include "apps/json_output.h"
#include "apps/rgbd_images.h"
#include "lib/common/error.h"
#include "lib/common/numbers.h"
#include "lib/geometry/undistort.h"

namespace secondlook::apps {
namespace {

struct RecogniseOptions {
  std::string models;
  std::string depth;
  std::string color;
  std::string camera;
  std::string up;
  std::string json;
  double depth_unit{};
};

/// Intrinsics and lens, as one command-line value has them.
struct Lens {
  geometry::CameraModel camera;
  geometry::LensDistortion distortion;
};

Lens ParseCamera(const std::string& text, int width, int height) {
  std::optional<std::vector<double>> numbers = ParseNumbers(text);
  if (!numbers) Throw<InvalidArgument>("--camera {}: is no list of numbers fx,fy,cx,cy", text);
  std::vector<double>& values = *numbers;
  if (values.size() < 4 || values.size() > 9) {
    Throw<InvalidArgument>(
        "--camera {}: {} values; give fx,fy,cx,cy or fx,fy,cx,cy,k1,k2,p1,p2,k3 (trailing zeros "
        "may be left out)",
        text, values.size());
  }
  values.resize(9, 0.0);
  Lens lens{{width, height, values[0], values[1], values[2], values[3]},
            {values[4], values[5], values[6], values[7], values[8]}};
  lens.camera.Validate("--camera");
  if (lens.camera.cx < 0 || lens.camera.cx > width || lens.camera.cy < 0 ||
      lens.camera.cy > height) {
    Throw<InvalidArgument>(
        "--camera {}: the principal point ({}, {}) lies outside the {} x {} depth image: these "
        "intrinsics are of another resolution",
        text, lens.camera.cx, lens.camera.cy, width, height);
  }
  return lens;
}

/// A detection's entry of the result: what was chosen, or its best guess. Null without any.
nlohmann::ordered_json ToJson(const world::Detection& detection, const perception::Choice& choice) {
  if (detection.hypotheses.empty()) return nullptr;
  const bool verified = choice.hypothesis >= 0;
  const world::Hypothesis& h =
      detection.hypotheses[verified ? static_cast<std::size_t>(choice.hypothesis) : 0];
  return {{"model", h.model},
          {"X_CM", MatrixToJson(h.X_CM)},
          {"score", h.score},
          {"probability", h.probability},
          {"verified", verified}};
}

void PrintTable(const perception::FrameRecognition& found) {
  for (std::size_t i = 0; i < found.detections.size(); ++i) {
    const world::Detection& detection = found.detections[i];
    const perception::Choice& choice = found.choices[i];
    const bool verified = choice.hypothesis >= 0;
    const Eigen::Vector3d& at = detection.cluster.center_C;
    fmt::print("cluster {:2}: {:6} pixels around ({:.3f}, {:.3f}, {:.3f}) m: ", i + 1,
               detection.cluster.pixels.size(), at.x(), at.y(), at.z());
    if (verified) {
      const world::Hypothesis& h =
          detection.hypotheses[static_cast<std::size_t>(choice.hypothesis)];
      const Eigen::Vector3d p = h.X_CM.translation();
      fmt::print("{} at ({:.3f}, {:.3f}, {:.3f}) m, score {:.3f}\n", h.model, p.x(), p.y(), p.z(),
                 h.score);
    } else {
      fmt::print("not recognised: {}\n", choice.reason);
    }
  }
}

void Recognise(const RecogniseOptions& options) {
  const auto database = world::ObjectDatabase::Load(options.models);
  cv::Mat depth = ReadDepthImage(options.depth, options.depth_unit);
  const Lens lens = ParseCamera(options.camera, depth.cols, depth.rows);
  cv::Mat color;
  if (!options.color.empty()) {
    color = geometry::Undistort(ReadColorImage(options.color, depth), lens.camera, lens.distortion);
  }
  depth = geometry::Undistort(depth, lens.camera, lens.distortion);
  const std::vector<perception::RecognitionModel> models = perception::TrainModels(database);

  perception::SegmentConfig segment_config;
  Eigen::Vector3d up_C = kImageUp_C;
  if (options.up.empty()) {
    segment_config.max_tilt_deg = kImageUpTolerance_deg;
    spdlog::info("no --up given: up is taken to lie within {} deg of image-up",
                 kImageUpTolerance_deg);
  } else {
    up_C = ParseUp(options.up);
  }
  const auto start = std::chrono::steady_clock::now();
  const perception::FrameRecognition found = perception::RecogniseFrame(
      color, depth, lens.camera, up_C, models, segment_config, perception::RecogniseConfig{});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  if (options.json != "-") {
    PrintTable(found);
    if (found.detections.empty()) fmt::print("nothing found: {}\n", found.reason);
  }
  if (options.json.empty()) return;
  nlohmann::ordered_json json{
      {"objects", nlohmann::ordered_json::array()}, {"seconds", seconds}, {"reason", found.reason}};
  std::vector<world::SupportPlane> planes = found.further_C;
  if (found.plane_C) planes.insert(planes.begin(), *found.plane_C);
  json["planes"] = PlanesToJson(planes);
  for (std::size_t i = 0; i < found.detections.size(); ++i) {
    const nlohmann::ordered_json object = ToJson(found.detections[i], found.choices[i]);
    if (!object.is_null()) json["objects"].push_back(object);
  }
  WriteJson(json, options.json);
}

}  // namespace

void AddRecognise(CLI::App* app, int*) {
  CLI::App* recognise =
      app->add_subcommand("recognise", "Finds the known objects in one colour and depth frame");
  const auto options = std::make_shared<RecogniseOptions>();  // outlives this function in callbacks
  recognise->add_option("--models", options->models, "Model folder")->required();
  recognise->add_option("--depth", options->depth, "Depth image, 16 bits; 0 = none")->required();
  recognise->add_option("--depth-unit", options->depth_unit, "Metres of one unit of depth")
      ->required();
  recognise->add_option("--camera", options->camera, "fx,fy,cx,cy[,k1,k2,p1,p2,k3] in pixels")
      ->required();
  recognise->add_option("--color", options->color, "Colour image registered to the depth image");
  recognise->add_option("--up", options->up,
                        "Direction against gravity in the camera frame: x,y,z");
  recognise->add_option("--json", options->json, "Result as JSON; - is standard output");
  recognise->callback([options] { Recognise(*options); });
}

}  // namespace secondlook::apps
