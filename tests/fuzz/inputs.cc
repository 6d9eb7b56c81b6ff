#include "tests/fuzz/inputs.h"

#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/experiments/npy.h"
#include "apps/rgbd_images.h"
#include "apps/run_config.h"
#include "lib/common/files.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/pcd.h"
#include "lib/hal/drivers/flir_ptu_link.h"
#include "lib/hal/drivers/rgbd_message.h"
#include "lib/hal/replay/recorder.h"
#include "lib/hal/replay/recording.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/kinematics/robot_model.h"
#include "lib/transport/channels.h"
#include "lib/transport/log_sink.h"
#include "lib/transport/message.h"
#include "lib/transport/message_json.h"
#include "lib/world/object_database.h"
#include "sim/scene.h"
#include "tests/support/fake_robot.h"
#include "tests/support/temporary_folder.h"

#include "bot_core/images_t.hpp"
#include "second_look/command_t.hpp"
#include "second_look/task_t.hpp"

namespace secondlook {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 8;  // of the images
constexpr int kHeight = 6;

std::string ToText(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

std::vector<std::uint8_t> ToBytes(const std::string& text) { return {text.begin(), text.end()}; }

/// What is read from a file with this name.
OutsideInput File(const std::string& name, const std::string& file, std::string seed,
                  std::function<void(const fs::path&)> read) {
  return {name, std::move(seed),
          [file, read = std::move(read)](const std::string& bytes, const fs::path& scratch) {
            WriteFile(scratch / file, bytes);
            read(scratch / file);
          }};
}

OutsideInput Mesh(const std::string& extension, std::string seed) {
  return File(extension, "a." + extension, std::move(seed),
              [](const fs::path& file) { geometry::LoadMesh(file, geometry::LengthUnit::kMetre); });
}

/// What comes in as a message of this type.
template <class T>
OutsideInput InMessage(const std::string& name, const std::string& type, const T& seed,
                       const std::function<void(const T&)>& use) {
  return {name, ToText(transport::Encode(seed)),
          [type, use](const std::string& bytes, const fs::path&) {
            const transport::Message message{"IN", 0, ToBytes(bytes)};
            transport::Check(message.bytes, type, {});
            use(transport::Decode<T>(message));
          }};
}

std::string NpySeed() {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
  header.resize(117, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + std::string(24, '\0');
}

std::string PictureSeed(const std::string& extension, int type) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, cv::Mat(kHeight, kWidth, type, cv::Scalar::all(100)), bytes);
  return ToText(bytes);
}

bot_core::images_t ImagesSeed() {
  bot_core::images_t images{};
  const auto add = [&](int type, int format, std::vector<std::uint8_t> data) {
    bot_core::image_t image{};
    image.width = kWidth;
    image.height = kHeight;
    image.pixelformat = format;
    image.size = static_cast<std::int32_t>(data.size());
    image.data = std::move(data);
    images.image_types.push_back(static_cast<std::int16_t>(type));
    images.images.push_back(image);
    ++images.n_images;
  };
  add(bot_core::images_t::LEFT, bot_core::image_t::PIXEL_FORMAT_MJPEG,
      ToBytes(PictureSeed(".jpg", CV_8UC3)));
  add(bot_core::images_t::DEPTH_MM, 0, std::vector<std::uint8_t>(2 * kWidth * kHeight, 4));
  return images;
}

hal::CameraInfo CameraOfImages() {
  return {"eye", {kWidth, kHeight, 8.0, 8.0, 3.5, 2.5}, true, 0.5, 6.0};
}

/// A mission of a few answers, recorded.
std::string LogSeed() {
  const TemporaryFolder folder;
  {
    testing::FakeWorld world;
    const hal::Robot robot = testing::MakeFakeRobot(&world);
    transport::LogSink log(folder / "log", 1 << 20);
    hal::Recorder recorder(&log);
    second_look::rec_mission_t mission{};
    hal::Describe(robot, kinematics::HeadCalibration::AtHeight(1.25), {}, &mission);
    mission.config = apps::ToText(apps::RunConfig{});
    recorder.Begin(mission);
    recorder.OnNow({});
    recorder.OnBaseState(robot.base->State());
    recorder.OnHeadState(robot.head->State());
    recorder.OnBaseStatus({hal::MotionPhase::kFailed, "blocked"});
  }
  return ReadFile(folder / "log");
}

/// A model's folder; its bytes are those of model.yaml.
OutsideInput Model() {
  const TemporaryFolder folder;
  geometry::SaveObj(geometry::MakeBox({0.1, 0.1, 0.1}, {0.5, 0.5, 0.5}), folder / "mesh");
  world::AddModel(folder / "mesh" / "mesh.obj", geometry::LengthUnit::kMetre, "thing",
                  folder / "models");
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder / "models" / "thing")) {
    files[entry.path().filename().string()] = ReadFile(entry.path());
  }
  return {"model", files.at("model.yaml"),
          [files](const std::string& bytes, const fs::path& scratch) {
            MakeWritableFolder(scratch / "thing");
            for (const auto& [name, content] : files) WriteFile(scratch / "thing" / name, content);
            WriteFile(scratch / "thing" / "model.yaml", bytes);
            world::ReadModel(scratch / "thing");
          }};
}

}  // namespace

std::vector<OutsideInput> OutsideInputs() {
  second_look::command_t command{};
  command.command = second_look::command_t::STOP;
  command.reason = "a hand in the way";
  second_look::task_t task{};
  task.num_wanted = 1;
  task.wanted.resize(1);
  task.wanted[0].name = "mug";
  return {
      Mesh("obj",
           "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvt 0 0\nvt 1 0\nvn 0 0 1\n"
           "f 1/1/1 2/2/1 3/1/1\nf 1/1/1 2/2/1 4/1/1\nf 1 3 4\nf 2 3 4\n"),
      Mesh("ply",
           "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
           "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
           "end_header\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 1 2\n3 0 1 3\n"),
      Mesh("stl",
           "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\n"
           "endloop\nendfacet\nendsolid a\n"),
      File("pcd", "a.pcd",
           "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
           "WIDTH 3\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\nDATA ascii\n"
           "0 0 1\n0.1 0 1\n0.2 0 1\n0 0.1 1\n0.1 0.1 1\nnan nan nan\n",
           [](const fs::path& file) { geometry::ReadPcd(file); }),
      File("npy", "a.npy", NpySeed(), [](const fs::path& file) { apps::ReadNpy(file); }),
      File("depth", "depth.png", PictureSeed(".png", CV_16UC1),
           [](const fs::path& file) { apps::ReadDepthImage(file, 0.001); }),
      File("colour", "color.png", PictureSeed(".png", CV_8UC3),
           [](const fs::path& file) {
             apps::ReadColorImage(file, cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(1.0)));
           }),
      {"urdf", ReadFile("sim/robots/arm.urdf"),
       [](const std::string& bytes, const fs::path&) { kinematics::ParseUrdf(bytes, "an input"); }},
      {"config", apps::ToText(apps::RunConfig{}),
       [](const std::string& bytes, const fs::path&) { apps::ParseRunConfig(bytes, "an input"); }},
      File("scene", "scene.yaml",
           "name: a\ntable:\n  position: [1.0, 0.5]\nwalls: {}\nobjects: []\n"
           "robot:\n  position: [0, 0]\n  yaw_deg: 20\n",
           [](const fs::path& file) { sim::LoadScene(file).Validate(); }),
      File("calibration", "c.yaml",
           "X_BH0: {position: [0.1, 0, 1.25]}\nX_HC: {rpy_deg: [-90, 0, -90]}\n"
           "residuals: {views: 60, pixels: 0.3, millimetres: 0.5, degrees: 0.04}\n",
           [](const fs::path& file) { kinematics::LoadCalibration(file); }),
      Model(),
      InMessage<second_look::command_t>("command", "second_look.command_t", command,
                                        [](const auto&) {}),
      InMessage<second_look::task_t>("task", "second_look.task_t", task, [](const auto&) {}),
      InMessage<bot_core::images_t>("images", "bot_core.images_t", ImagesSeed(),
                                    [](const bot_core::images_t& images) {
                                      hal::ReadImages(images, CameraOfImages(), Seconds(0.02));
                                    }),
      File("log", "log", LogSeed(), [](const fs::path& file) { hal::Recording::Load(file); }),
      {"ptu", "!P!Tpp * Current Pan position is -1200",
       [](const std::string& bytes, const fs::path&) { hal::PtuAnswerIn(bytes, "pp", true); }},
  };
}

}  // namespace secondlook
