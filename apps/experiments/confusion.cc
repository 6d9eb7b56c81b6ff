#include "apps/experiments/confusion.h"

#include <algorithm>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/files.h"

namespace secondlook::apps {
namespace {

constexpr int kCell_px = 56;
constexpr int kMargin_px = 150;  // for the names
constexpr double kTextScale = 0.42;

void Write(const std::string& text, cv::Point at, const cv::Scalar& color, cv::Mat* picture) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kTextScale, color, 1, cv::LINE_AA);
}

/// The names of the columns are written upwards.
void WriteUpwards(const std::string& text, int column_px, cv::Mat* picture) {
  cv::Mat strip(kCell_px / 2, kMargin_px - 30, CV_8UC3, cv::Scalar::all(255));
  Write(text, {4, kCell_px / 4 + 4}, cv::Scalar::all(0), &strip);
  cv::rotate(strip, strip, cv::ROTATE_90_COUNTERCLOCKWISE);
  strip.copyTo((*picture)(cv::Rect({column_px + kCell_px / 4, 30}, strip.size())));
}

}  // namespace

void ConfusionMatrix::Add(int truth, int said) { counts_(At(truth), At(said)) += 1.0; }

ConfusionMatrix& ConfusionMatrix::operator+=(const ConfusionMatrix& other) {
  counts_ += other.counts_;
  return *this;
}

double ConfusionMatrix::Accuracy() const {
  const auto classes = counts_.rows() - 1;
  const double things = counts_.topRows(classes).sum();
  return things > 0.0 ? counts_.diagonal().head(classes).sum() / things : 0.0;
}

double ConfusionMatrix::Precision() const {
  const auto classes = counts_.rows() - 1;
  double sum = 0.0;
  for (Eigen::Index c = 0; c < classes; ++c) {
    const double said = counts_.col(c).sum();
    if (said > 0.0) sum += counts_(c, c) / said;
  }
  return sum / static_cast<double>(classes);
}

double ConfusionMatrix::Recall() const {
  const auto classes = counts_.rows() - 1;
  double sum = 0.0;
  double present = 0.0;
  for (Eigen::Index c = 0; c < classes; ++c) {
    const double things = counts_.row(c).sum();
    if (things == 0.0) continue;
    sum += counts_(c, c) / things;
    present += 1.0;
  }
  return present > 0.0 ? sum / present : 0.0;
}

double ConfusionMatrix::F1() const {
  const double sum = Precision() + Recall();
  return sum > 0.0 ? 2.0 * Precision() * Recall() / sum : 0.0;
}

void WritePicture(const ConfusionMatrix& matrix, const std::vector<std::string>& classes,
                  const std::string& title, const std::filesystem::path& path) {
  const Eigen::MatrixXd& counts = matrix.counts();
  const auto size = static_cast<int>(counts.rows());
  const int side_px = kMargin_px + size * kCell_px + 10;
  cv::Mat picture(side_px, side_px, CV_8UC3, cv::Scalar::all(255));
  Write(title, {10, 20}, cv::Scalar::all(0), &picture);
  for (int row = 0; row < size; ++row) {
    const std::string name = row + 1 < size ? classes[row] : "Background";
    const int y = kMargin_px + row * kCell_px;
    Write(name, {10, y + kCell_px / 2 + 4}, cv::Scalar::all(0), &picture);
    WriteUpwards(name, y, &picture);
    const double total = std::max(1.0, counts.row(row).sum());
    for (int column = 0; column < size; ++column) {
      const double share = counts(row, column) / total;
      const cv::Rect cell(kMargin_px + column * kCell_px, y, kCell_px, kCell_px);
      const cv::Scalar shade(255.0, 255.0 - 120.0 * share, 255.0 - 225.0 * share);  // BGR
      cv::rectangle(picture, cell, shade, cv::FILLED);
      cv::rectangle(picture, cell, cv::Scalar::all(200), 1);
      if (counts(row, column) == 0.0) continue;
      Write(fmt::format("{:.0f}", counts(row, column)), {cell.x + 10, cell.y + kCell_px / 2 + 4},
            cv::Scalar::all(share > 0.5 ? 255 : 0), &picture);
    }
  }
  std::vector<unsigned char> png;
  cv::imencode(".png", picture, png);
  WriteFile(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace secondlook::apps
