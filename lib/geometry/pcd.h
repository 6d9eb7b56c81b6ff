#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "lib/geometry/point_image.h"

namespace secondlook::geometry {

/// Reads the x, y and z of a point cloud in the PCD format 0.7, ASCII, binary or compressed; other
/// fields are skipped. HEIGHT > 1 makes an organised cloud. PCD has no unit: the values are taken
/// for metres, and points that are not finite, or the origin, for "none".
/// @throws ConfigError naming the file when it is missing, truncated, no PCD, larger than 16
/// million points, or lacks x, y or z.
PointImage ReadPcd(const std::filesystem::path& file);

/// A point cloud in which someone has said what each point belongs to.
struct LabelledCloud {
  PointImage cloud;
  std::vector<std::uint32_t> labels;  ///< One per point; what they mean is the file's business.
};

/// Likewise, with the field `label`, an unsigned integer of 4 bytes.
/// @throws ConfigError as above, or when there is no such field.
LabelledCloud ReadLabelledPcd(const std::filesystem::path& file);

}  // namespace secondlook::geometry
