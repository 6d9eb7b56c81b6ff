#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include "lib/geometry/mesh.h"

namespace secondlook::apps {

/// `mesh`, whose z axis points up, seen from above its front, in its colours and lit from where it
/// is seen; white around. [size, size] CV_8UC3, RGB. What is open is seen through.
/// @pre !mesh.empty(), size >= 16.
cv::Mat DrawModel(const geometry::Mesh& mesh, int size);

/// Writes that picture as PNG. @throws ConfigError when it cannot.
void SaveModelPicture(const geometry::Mesh& mesh, const std::filesystem::path& file);

}  // namespace secondlook::apps
