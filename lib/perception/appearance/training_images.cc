#include "lib/perception/appearance/training_images.h"

#include <algorithm>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/hash.h"

namespace secondlook::perception {
namespace {

namespace fs = std::filesystem;

/// Whether a JPEG has no end-of-image marker: decoders fill what is missing with grey and go on.
bool EndsTooEarly(const std::string& bytes) {
  return bytes.starts_with("\xff\xd8") && bytes.rfind("\xff\xd9") == std::string::npos;
}

cv::Mat Decode(const std::string& bytes, const fs::path& path) {
  if (EndsTooEarly(bytes)) {
    Throw<ConfigError>("{}: a JPEG without its end; get the whole file", path.string());
  }
  const std::vector<unsigned char> buffer(bytes.begin(), bytes.end());
  const cv::Mat bgr = buffer.empty() ? cv::Mat() : cv::imdecode(buffer, cv::IMREAD_COLOR);
  if (bgr.empty()) Throw<ConfigError>("{}: no image", path.string());
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

std::vector<fs::path> Sorted(const fs::path& folder, bool folders) {
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() == folders) entries.push_back(entry.path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

}  // namespace

cv::Mat ReadImage(const fs::path& path) { return Decode(ReadFile(path), path); }

TrainingSet ReadTrainingSet(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    Throw<ConfigError>("{}: no such folder; it must hold a folder of images for each class",
                       folder.string());
  }
  TrainingSet set;
  std::uint64_t hash = Fnv1a("");
  for (const fs::path& class_folder : Sorted(folder, true)) {
    const int label = static_cast<int>(set.classes.size());
    set.classes.push_back(class_folder.filename().string());
    const std::size_t before = set.images.size();
    for (const fs::path& path : Sorted(class_folder, false)) {
      const std::string bytes = ReadFile(path);
      try {
        set.images.push_back({path, label, Decode(bytes, path)});
        hash = Fnv1a(bytes, Fnv1a(fs::relative(path, folder).string(), hash));
      } catch (const ConfigError& error) {
        set.left_out.emplace_back(error.what());
      }
    }
    if (set.images.size() == before) {
      Throw<ConfigError>("{}: the class has no image; put some in or remove the folder",
                         class_folder.string());
    }
  }
  if (set.classes.size() < 2) {
    Throw<ConfigError>("{}: has {} classes; a classifier needs at least two sub-folders of images",
                       folder.string(), set.classes.size());
  }
  set.hash = "fnv1a " + HexDigits(hash);
  return set;
}

}  // namespace secondlook::perception
