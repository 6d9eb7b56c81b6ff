#include "lib/hal/drivers/openni2_camera.h"

#include <array>
#include <cmath>
#include <utility>

#include <OpenNI.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr int kPatienceMs = 1000;  // without a frame

/// The library, for as long as a camera wants it: it counts its users itself.
class Library {
 public:
  explicit Library(const std::string& camera) {
    if (openni::OpenNI::initialize() == openni::STATUS_OK) return;
    Throw<DeviceError>("camera '{}': OpenNI2 cannot begin: {}", camera, Said());
  }
  ~Library() { openni::OpenNI::shutdown(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  /// What OpenNI2 says of its last error, on one line.
  static std::string Said() {
    std::string text = openni::OpenNI::getExtendedError();
    for (char& c : text) c = c == '\n' || c == '\t' ? ' ' : c;
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text.empty() ? "it does not say why" : text;
  }
};

void Require(openni::Status status, const std::string& camera, const std::string& what) {
  if (status == openni::STATUS_OK) return;
  Throw<DeviceError>("camera '{}': {}: {}", camera, what, Library::Said());
}

/// Metres a count of the depth format; 0 for another format.
double DepthUnit(openni::PixelFormat format) {
  if (format == openni::PIXEL_FORMAT_DEPTH_1_MM) return 1e-3;
  return format == openni::PIXEL_FORMAT_DEPTH_100_UM ? 1e-4 : 0.0;
}

cv::Mat ColorOf(const openni::VideoFrameRef& frame) {
  const cv::Mat pixels(frame.getHeight(), frame.getWidth(), CV_8UC3,
                       const_cast<void*>(frame.getData()),
                       static_cast<std::size_t>(frame.getStrideInBytes()));
  return pixels.clone();
}

cv::Mat DepthOf(const openni::VideoFrameRef& frame, double unit, double nearest, double farthest) {
  cv::Mat depth(frame.getHeight(), frame.getWidth(), CV_32FC1);
  const auto* bytes = static_cast<const std::uint8_t*>(frame.getData());
  for (int v = 0; v < depth.rows; ++v) {
    const auto* row = reinterpret_cast<const std::uint16_t*>(bytes + v * frame.getStrideInBytes());
    auto* out = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const double z = row[u] * unit;
      out[u] = static_cast<float>(z >= nearest && z <= farthest ? z : NAN);
    }
  }
  return depth;
}

}  // namespace

/// An open device with its two streams. One thread alone reads from it for as long as the camera
/// lives: OpenNI2 remembers every thread that ever waited for images, and asks after those that
/// have ended, which crashes.
struct OpenNi2Camera::Device {
  Library library;
  openni::Device device;
  openni::VideoStream depth;
  openni::VideoStream color;
  double depth_unit{};

  explicit Device(const OpenNi2Config& config) : library(config.name) {
    const std::string where = config.uri.empty() ? "any OpenNI2 device" : config.uri;
    Require(device.open(config.uri.empty() ? openni::ANY_DEVICE : config.uri.c_str()), config.name,
            where + " cannot be opened");
    Open(config, openni::SENSOR_DEPTH, "depth", &depth);
    Open(config, openni::SENSOR_COLOR, "colour", &color);
    depth_unit = DepthUnit(depth.getVideoMode().getPixelFormat());
    if (depth_unit == 0.0) {
      Throw<DeviceError>("camera '{}': its depth is neither in 1 mm nor in 0.1 mm", config.name);
    }
    if (!device.isFile()) {
      // A recording has what was set when it was made.
      constexpr auto kToColor = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
      const bool registers = device.isImageRegistrationModeSupported(kToColor) &&
                             device.setImageRegistrationMode(kToColor) == openni::STATUS_OK;
      if (!registers) {
        Throw<DeviceError>("camera '{}': it cannot register depth to colour", config.name);
      }
      device.setDepthColorSyncEnabled(true);  // pairs are told by their stamps, whatever it says
    }
    Require(depth.start(), config.name, "depth cannot begin");
    Require(color.start(), config.name, "colour cannot begin");
  }

  ~Device() {
    for (openni::VideoStream* stream : {&depth, &color}) {
      stream->stop();
      stream->destroy();
    }
    device.close();
  }

  /// Waits for the next image of either stream; false when none came in time.
  bool Read(const std::string& camera, openni::VideoFrameRef* depth_image,
            openni::VideoFrameRef* color_image) {
    std::array<openni::VideoStream*, 2> streams{&depth, &color};
    int ready = -1;
    const openni::Status status =
        openni::OpenNI::waitForAnyStream(streams.data(), 2, &ready, kPatienceMs);
    if (status == openni::STATUS_TIME_OUT) return false;
    Require(status, camera, "is lost");
    Require(
        streams[static_cast<std::size_t>(ready)]->readFrame(ready == 0 ? depth_image : color_image),
        camera, "is lost");
    return true;
  }

 private:
  void Open(const OpenNi2Config& config, openni::SensorType sensor, const std::string& what,
            openni::VideoStream* stream) {
    Require(stream->create(device, sensor), config.name, "it has no " + what);
    if (!device.isFile()) {
      openni::VideoMode mode = stream->getVideoMode();
      mode.setResolution(config.width, config.height);
      mode.setFps(config.fps);
      mode.setPixelFormat(sensor == openni::SENSOR_DEPTH ? openni::PIXEL_FORMAT_DEPTH_1_MM
                                                         : openni::PIXEL_FORMAT_RGB888);
      Require(stream->setVideoMode(mode), config.name,
              fmt::format("it has no {} of {} x {} at {} a second", what, config.width,
                          config.height, config.fps));
      stream->setMirroringEnabled(false);  // some mirror by default, others cannot
    }
    const openni::VideoMode mode = stream->getVideoMode();
    if (mode.getResolutionX() != config.width || mode.getResolutionY() != config.height) {
      Throw<DeviceError>("camera '{}': its {} is {} x {} and not {} x {}: set width and height",
                         config.name, what, mode.getResolutionX(), mode.getResolutionY(),
                         config.width, config.height);
    }
  }
};

void OpenNi2Config::Validate() const {
  if (name.empty()) Throw<ConfigError>("'name' is empty: messages call the camera by it");
  CheckRange(width, 1, 8192, "'width'");
  CheckRange(height, 1, 8192, "'height'");
  CheckRange(fps, 1, 300, "'fps'");
  CheckRange(min_depth, 0.0, 100.0, "'min_depth'");
  CheckRange(max_depth, min_depth, 100.0, "'max_depth'");
  CheckRange(latency_seconds, 0.0, 1.0, "'latency_seconds'");
  if (!intrinsics.empty() && intrinsics.size() != 4) {
    Throw<ConfigError>("'intrinsics' has {} values; give fx, fy, cx and cy, or leave it out",
                       intrinsics.size());
  }
}

OpenNi2Camera::OpenNi2Camera(const OpenNi2Config& config, const Clock* clock)
    : config_(config), clock_(clock), device_time_(Seconds(config.latency_seconds)) {
  config_.Validate();
  device_ = std::make_unique<Device>(config_);
  CameraModel model{config.width, config.height};
  if (config.intrinsics.empty()) {
    model.fx = 0.5 * config.width / std::tan(0.5 * device_->color.getHorizontalFieldOfView());
    model.fy = 0.5 * config.height / std::tan(0.5 * device_->color.getVerticalFieldOfView());
    model.cx = 0.5 * (config.width - 1);
    model.cy = 0.5 * (config.height - 1);
    spdlog::warn("camera '{}': its intrinsics are those of its kind, {:.1f} px; calibrate it",
                 config.name, model.fx);
  } else {
    model.fx = config.intrinsics[0];
    model.fy = config.intrinsics[1];
    model.cx = config.intrinsics[2];
    model.cy = config.intrinsics[3];
  }
  model.Validate(("camera '" + config.name + "'").c_str());
  info_ = {config.name, model, true, config.min_depth, config.max_depth};
  thread_ = std::thread([this] { Run(); });
}

OpenNi2Camera::~OpenNi2Camera() {
  quit_ = true;
  thread_.join();
}

std::optional<RgbdFrame> OpenNi2Camera::Grab(Duration timeout) { return mailbox_.Take(timeout); }

void OpenNi2Camera::Run() {
  while (!quit_) {
    try {
      if (device_ == nullptr) {
        device_ = std::make_unique<Device>(config_);
        spdlog::warn("camera '{}': was opened anew", config_.name);
      }
      Capture();
    } catch (const Error& error) {
      device_.reset();
      mailbox_.Lose(error.what());
      for (int i = 0; i < 20 && !quit_; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    }
  }
}

/// Captures until there is nothing more to do; throws when the device is lost.
void OpenNi2Camera::Capture() {
  const auto half_period_us = static_cast<std::int64_t>(5e5 / config_.fps);
  openni::VideoFrameRef depth;
  openni::VideoFrameRef color;
  while (!quit_) {
    if (!device_->Read(config_.name, &depth, &color)) {
      Throw<DeviceError>("camera '{}': is lost: nothing came from it for {} s", config_.name,
                         0.001 * kPatienceMs);
    }
    const Time arrival = clock_->Now();
    if (!depth.isValid() || !color.isValid()) continue;
    const auto depth_us = static_cast<std::int64_t>(depth.getTimestamp());
    const auto color_us = static_cast<std::int64_t>(color.getTimestamp());
    if (std::abs(depth_us - color_us) > half_period_us) continue;  // the other one is to come
    const Duration stamp = std::chrono::microseconds(depth_us);
    mailbox_.Put({device_time_.Of(stamp, arrival), ++sequence_, ColorOf(color),
                  DepthOf(depth, device_->depth_unit, config_.min_depth, config_.max_depth)});
    depth.release();
    color.release();
  }
}

}  // namespace secondlook::hal
