#include "lib/hal/drivers/video_camera.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include <spdlog/spdlog.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr auto kNap = std::chrono::milliseconds(20);
constexpr int kNapsToReconnect = 50;

/// A file, or pictures that are numbered: no device.
bool IsFile(const std::string& source) {
  return source.find('%') != std::string::npos || std::filesystem::is_regular_file(source);
}

bool IsPipeline(const std::string& source) { return source.find('!') != std::string::npos; }

}  // namespace

/// An open source of frames.
struct VideoCamera::Source {
  const VideoCameraConfig& config;
  cv::VideoCapture capture;

  explicit Source(const VideoCameraConfig& c) : config(c) {
    // Each by its own reader: the others would complain at length.
    const int reader = IsPipeline(c.source)            ? cv::CAP_GSTREAMER
                       : c.source.starts_with("/dev/") ? cv::CAP_V4L2
                                                       : cv::CAP_ANY;
    if (!capture.open(c.source, reader)) {
      Throw<DeviceError>(
          "camera '{}': {} cannot be opened: is it plugged in, and may this user read it (group "
          "video)?",
          c.name, c.source);
    }
    if (IsFile(c.source) || IsPipeline(c.source)) return;
    capture.set(cv::CAP_PROP_FRAME_WIDTH, c.width);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, c.height);
    capture.set(cv::CAP_PROP_FPS, c.fps);
  }

  /// The next frame, RGB, as the lens has it.
  cv::Mat Read() {
    cv::Mat bgr;
    if (!capture.read(bgr) || bgr.empty()) {
      Throw<DeviceError>("camera '{}': {} {}", config.name, config.source,
                         IsFile(config.source) ? "has ended" : "gives no more frames");
    }
    if (bgr.cols != config.width || bgr.rows != config.height || bgr.type() != CV_8UC3) {
      Throw<DeviceError>(
          "camera '{}': {} gives {} x {} with {} channels, and not {} x {} with 3: set width, "
          "height and intrinsics",
          config.name, config.source, bgr.cols, bgr.rows, bgr.channels(), config.width,
          config.height);
    }
    cv::Mat rgb;
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    return rgb;
  }
};

void VideoCameraConfig::Validate() const {
  if (name.empty()) Throw<ConfigError>("'name' is empty: messages call the camera by it");
  if (source.empty()) Throw<ConfigError>("'source' is empty: give a device, e.g. /dev/video0");
  CheckRange(width, 1, 8192, "'width'");
  CheckRange(height, 1, 8192, "'height'");
  CheckRange(fps, 0.1, 1000.0, "'fps'");
  CheckRange(latency_seconds, 0.0, 2.0, "'latency_seconds'");
  if (intrinsics.size() != 4) {
    Throw<ConfigError>("'intrinsics' has {} values; give fx, fy, cx and cy [px]",
                       intrinsics.size());
  }
  if (!distortion.empty() && distortion.size() != 5) {
    Throw<ConfigError>("'distortion' has {} values; give k1, k2, p1, p2 and k3, or leave it out",
                       distortion.size());
  }
  for (const double value : distortion) CheckRange(value, -10.0, 10.0, "'distortion'");
}

VideoCamera::VideoCamera(const VideoCameraConfig& config, const Clock* clock)
    : config_(config), clock_(clock) {
  config_.Validate();
  const std::vector<double>& k = config_.intrinsics;
  info_ = {config_.name, {config_.width, config_.height, k[0], k[1], k[2], k[3]}, false, 0.0, 0.0};
  info_.model.Validate(("camera '" + config_.name + "'").c_str());
  if (!config_.distortion.empty()) {
    const std::vector<double>& d = config_.distortion;
    lens_ = {d[0], d[1], d[2], d[3], d[4]};
  }
  source_ = std::make_unique<Source>(config_);
  source_->Read();
  thread_ = std::thread([this] { Run(); });
}

VideoCamera::~VideoCamera() {
  quit_ = true;
  thread_.join();
}

std::optional<RgbdFrame> VideoCamera::Grab(Duration timeout) {
  std::optional<RgbdFrame> frame = mailbox_.Take(timeout);
  if (frame && !lens_.none()) {
    frame->color = geometry::Undistort(frame->color, info_.model, lens_);
  }
  return frame;
}

void VideoCamera::Run() {
  const auto period = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(1.0 / config_.fps));
  while (!quit_) {
    try {
      if (source_ == nullptr) {
        source_ = std::make_unique<Source>(config_);
        spdlog::warn("camera '{}': was opened anew", config_.name);
      }
      auto next = std::chrono::steady_clock::now();
      while (!quit_) {
        cv::Mat color = source_->Read();
        const Time time = clock_->Now() - Seconds(config_.latency_seconds);
        mailbox_.Put({time, ++sequence_, std::move(color), {}});
        next += period;
        if (IsFile(config_.source)) std::this_thread::sleep_until(next);
      }
    } catch (const Error& error) {
      source_.reset();
      mailbox_.Lose(error.what());
      if (IsFile(config_.source)) return;
      for (int i = 0; i < kNapsToReconnect && !quit_; ++i) std::this_thread::sleep_for(kNap);
    }
  }
}

}  // namespace secondlook::hal
