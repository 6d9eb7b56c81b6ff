#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

namespace secondlook::hal {

inline constexpr int kVirtualWidth = 640;
inline constexpr int kVirtualHeight = 480;

/// What the virtual OpenNI2 camera shows, and how it is.
struct VirtualRgbd {
  std::mutex mutex;  ///< Of the pixels.
  std::vector<std::uint16_t> depth_mm =
      std::vector<std::uint16_t>(kVirtualWidth * kVirtualHeight, 1000);
  std::vector<std::uint8_t> rgb = std::vector<std::uint8_t>(kVirtualWidth * kVirtualHeight * 3, 99);
  std::atomic<bool> connected{true};  ///< It sends frames and can be opened.
  std::atomic<bool> registers{true};  ///< It can register depth to colour.
};

}  // namespace secondlook::hal
