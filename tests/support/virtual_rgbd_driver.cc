// A driver for OpenNI2 itself, so that our camera can be tested through the real library without a
// device: a camera of 640 x 480 that shows what the test has put there
// (tests/drivers/virtual_rgbd.h).

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <memory>
#include <mutex>
#include <thread>

// Debian's header leaves these to the library that it was taken from.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(object) delete object
#include <Driver/OniDriverAPI.h>

#include "tests/drivers/virtual_rgbd.h"

namespace {

using secondlook::hal::kVirtualHeight;
using secondlook::hal::kVirtualWidth;
using secondlook::hal::VirtualRgbd;

constexpr int kFps = 30;
constexpr std::size_t kPixels = static_cast<std::size_t>(kVirtualWidth) * kVirtualHeight;

VirtualRgbd& Shown() {
  static VirtualRgbd shown;
  return shown;
}

class Stream : public oni::driver::StreamBase {
 public:
  explicit Stream(OniSensorType sensor) : sensor_(sensor) {}
  ~Stream() override { stop(); }

  OniStatus start() override {
    running_ = true;
    thread_ = std::thread([this] { Run(); });
    return ONI_STATUS_OK;
  }

  void stop() override {
    running_ = false;
    if (thread_.joinable()) thread_.join();
  }

  OniStatus setProperty(int id, const void* data, int size) override {
    if (id == ONI_STREAM_PROPERTY_MIRRORING) return ONI_STATUS_OK;
    if (id != ONI_STREAM_PROPERTY_VIDEO_MODE || size != sizeof(OniVideoMode)) {
      return ONI_STATUS_NOT_SUPPORTED;
    }
    OniVideoMode mode;
    std::memcpy(&mode, data, sizeof mode);
    const OniVideoMode own = Mode(sensor_);
    return std::memcmp(&mode, &own, sizeof mode) == 0 ? ONI_STATUS_OK : ONI_STATUS_BAD_PARAMETER;
  }

  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return Give(Mode(sensor_), data, size);
      // A recording without this is never played back.
      case ONI_STREAM_PROPERTY_CROPPING:
        return Give(OniCropping{}, data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return Give(1.0144686F, data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return Give(0.7898090F, data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return Give(10000, data, size);
      case ONI_STREAM_PROPERTY_MIRRORING:
        return Give(OniBool{FALSE}, data, size);
      default:
        return ONI_STATUS_NOT_IMPLEMENTED;
    }
  }

  OniBool isPropertySupported(int id) override {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_CROPPING ||
           id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV || id == ONI_STREAM_PROPERTY_VERTICAL_FOV ||
           id == ONI_STREAM_PROPERTY_MAX_VALUE || id == ONI_STREAM_PROPERTY_MIRRORING;
  }

  static OniVideoMode Mode(OniSensorType sensor) {
    return {sensor == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888,
            kVirtualWidth, kVirtualHeight, kFps};
  }

 private:
  template <class T>
  static OniStatus Give(const T& value, void* data, int* size) {
    if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof value);
    *size = sizeof value;
    return ONI_STATUS_OK;
  }

  void Run() {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 1; running_; ++i) {
      std::this_thread::sleep_until(begin + i * std::chrono::microseconds(1'000'000 / kFps));
      if (!Shown().connected) continue;
      OniFrame* frame = getServices().acquireFrame();
      if (frame == nullptr) continue;
      const OniVideoMode mode = Mode(sensor_);
      const int pixel_bytes = sensor_ == ONI_SENSOR_DEPTH ? 2 : 3;
      frame->frameIndex = i;
      frame->sensorType = sensor_;
      frame->timestamp = static_cast<std::uint64_t>(i) * 1'000'000 / kFps;
      frame->width = mode.resolutionX;
      frame->height = mode.resolutionY;
      frame->videoMode = mode;
      frame->croppingEnabled = FALSE;
      frame->stride = mode.resolutionX * pixel_bytes;
      frame->dataSize = static_cast<int>(kPixels) * pixel_bytes;
      {
        const std::scoped_lock lock(Shown().mutex);
        const void* pixels = sensor_ == ONI_SENSOR_DEPTH
                                 ? static_cast<const void*>(Shown().depth_mm.data())
                                 : static_cast<const void*>(Shown().rgb.data());
        std::memcpy(frame->data, pixels, static_cast<std::size_t>(frame->dataSize));
      }
      raiseNewFrame(frame);
      getServices().releaseFrame(frame);
    }
  }

  OniSensorType sensor_;
  std::atomic<bool> running_{false};
  std::thread thread_;
};

class Camera : public oni::driver::DeviceBase {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_;
    *count = 2;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    return sensor == ONI_SENSOR_IR ? nullptr : new Stream(sensor);
  }
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }
  OniStatus setProperty(int id, const void*, int) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION ? ONI_STATUS_OK
                                                        : ONI_STATUS_NOT_IMPLEMENTED;
  }
  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode) override {
    return Shown().registers ? TRUE : FALSE;
  }

 private:
  OniVideoMode depth_ = Stream::Mode(ONI_SENSOR_DEPTH);
  OniVideoMode color_ = Stream::Mode(ONI_SENSOR_COLOR);
  OniSensorInfo sensors_[2] = {{ONI_SENSOR_DEPTH, 1, &depth_}, {ONI_SENSOR_COLOR, 1, &color_}};
};

class Driver : public oni::driver::DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    static OniDeviceInfo info{"virtual://0", "Second Look", "virtual camera", 0, 0};
    deviceConnected(&info);
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char*, const char*) override {
    return Shown().connected ? new Camera : nullptr;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}
};

}  // namespace

extern "C" VirtualRgbd* TheVirtualRgbd() { return &Shown(); }

ONI_EXPORT_DRIVER(Driver)
