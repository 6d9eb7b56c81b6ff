// What it takes to choose the side for the next view of one object, one thread: all criteria but
// the classifier's, of crops as large as the published ones (69 x 65 pixels in the median, 185 at
// most) and of one that fills a picture.
//   tile_choice [--benchmark_…]
#include <cmath>

#include <benchmark/benchmark.h>

#include "lib/planning/tile_vote.h"

namespace secondlook::bench {
namespace {

/// A matt ball before a wall.
planning::ObjectCrop Ball(int side_px) {
  planning::ObjectCrop crop{cv::Mat(side_px, side_px, CV_8UC3, cv::Scalar(90, 90, 90)),
                            cv::Mat(side_px, side_px, CV_32FC1, cv::Scalar(1.2)), 525.0};
  for (int v = 0; v < side_px; ++v) {
    for (int u = 0; u < side_px; ++u) {
      const double x = 2.0 * u / side_px - 1.0;
      const double y = 2.0 * v / side_px - 1.0;
      const double height = std::sqrt(std::max(0.0, 0.8 - x * x - y * y));
      if (height == 0.0) continue;
      crop.depth.at<float>(v, u) = static_cast<float>(0.8 - 0.05 * height);
      const double level = 60.0 + 120.0 * height - 40.0 * x;
      crop.color.at<cv::Vec3b>(v, u) = cv::Vec3b::all(static_cast<std::uint8_t>(level));
    }
  }
  return crop;
}

void ChooseSide(benchmark::State& state) {
  const planning::ObjectCrop crop = Ball(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        planning::RankTiles(planning::ScoreTiles(crop, nullptr), planning::PaperVoters()));
  }
}
BENCHMARK(ChooseSide)->Arg(67)->Arg(185)->Arg(480)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace secondlook::bench

BENCHMARK_MAIN();
