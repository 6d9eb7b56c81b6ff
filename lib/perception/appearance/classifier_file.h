#pragma once

#include <filesystem>
#include <functional>

#include <opencv2/core/persistence.hpp>

#include "lib/perception/appearance/classifier.h"

namespace secondlook::perception {

/// Writes a model file: `header`, then what `content` adds (OpenCV's YAML).
/// @throws ConfigError naming the file when it cannot be written.
void WriteClassifierFile(const std::filesystem::path& path, const ClassifierHeader& header,
                         const std::function<void(cv::FileStorage*)>& content);

}  // namespace secondlook::perception
