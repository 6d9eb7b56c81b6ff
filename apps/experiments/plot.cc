#include "apps/experiments/plot.h"

#include <array>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/files.h"

namespace secondlook::apps {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;
const cv::Rect kFrame(70, 40, 540, 380);
constexpr int kTicks = 5;

/// Told apart by most people who do not see all colours (Okabe and Ito 2008); BGR.
const std::array<cv::Scalar, 6> kColors{
    {{178, 114, 0}, {0, 94, 213}, {115, 158, 0}, {167, 121, 204}, {0, 159, 230}, {0, 0, 0}}};

void Write(const std::string& text, cv::Point at, const cv::Scalar& color, cv::Mat* picture) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, color, 1, cv::LINE_AA);
}

cv::Point PixelOf(const PlotAxes& axes, const Eigen::Vector2d& p) {
  const Eigen::Array2d share = (p - axes.low).array() / (axes.high - axes.low).array();
  return {kFrame.x + cvRound(share.x() * kFrame.width),
          kFrame.y + kFrame.height - cvRound(share.y() * kFrame.height)};
}

}  // namespace

void WritePlot(const PlotAxes& axes, const std::vector<Curve>& curves,
               const std::filesystem::path& path) {
  const cv::Scalar black = cv::Scalar::all(0);
  cv::Mat picture(kHeight_px, kWidth_px, CV_8UC3, cv::Scalar::all(255));
  Write(axes.title, {kFrame.x, 24}, black, &picture);
  Write(axes.x, {kFrame.x + kFrame.width / 3, kHeight_px - 12}, black, &picture);
  Write(axes.y, {8, kFrame.y - 8}, black, &picture);
  for (int i = 0; i <= kTicks; ++i) {
    const Eigen::Vector2d tick = axes.low + (axes.high - axes.low) * i / kTicks;
    const cv::Point at = PixelOf(axes, tick);
    cv::line(picture, {at.x, kFrame.y}, {at.x, kFrame.br().y}, cv::Scalar::all(225));
    cv::line(picture, {kFrame.x, at.y}, {kFrame.br().x, at.y}, cv::Scalar::all(225));
    Write(fmt::format("{:.2f}", tick.x()), {at.x - 14, kFrame.br().y + 18}, black, &picture);
    Write(fmt::format("{:.2f}", tick.y()), {kFrame.x - 40, at.y + 4}, black, &picture);
  }
  cv::rectangle(picture, kFrame, black);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const cv::Scalar& color = kColors[i % kColors.size()];
    std::vector<cv::Point> line;
    for (const Eigen::Vector2d& p : curves[i].points) line.push_back(PixelOf(axes, p));
    cv::polylines(picture, line, false, color, 2, cv::LINE_AA);
    const int y = kFrame.br().y - 14 - 18 * static_cast<int>(curves.size() - 1 - i);
    Write(curves[i].name, {kFrame.br().x - 180, y}, color, &picture);
  }
  std::vector<unsigned char> png;
  cv::imencode(".png", picture, png);
  WriteFile(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace secondlook::apps
