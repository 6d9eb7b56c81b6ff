#include "apps/view_picture.h"

#include <algorithm>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace secondlook::apps {
namespace {

cv::Scalar ColorOf(world::ObjectState state) {
  switch (state) {
    case world::ObjectState::kVerified:
    case world::ObjectState::kClassified:
    case world::ObjectState::kModelled:
      return {60, 220, 90};
    case world::ObjectState::kUnknown:
      return {200, 110, 255};
    default:
      return {255, 170, 40};
  }
}

std::string Caption(const world::ObjectBelief& object) {
  switch (object.state) {
    case world::ObjectState::kVerified:
      return object.Best()->model;
    case world::ObjectState::kClassified:
      return object.LeadingClass();
    case world::ObjectState::kUnknown:
      return "unknown";
    default:
      return object.Best() == nullptr ? "?" : object.Best()->model + "?";
  }
}

void DrawText(const std::string& text, const cv::Point& at, const cv::Scalar& color,
              cv::Mat* picture) {
  constexpr double kScale = 0.45;
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kScale, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, kScale, color, 1, cv::LINE_AA);
}

void DrawThing(const world::Cluster& cluster, const std::string& caption, const cv::Scalar& color,
               cv::Mat* picture) {
  cv::Mat mask = cv::Mat::zeros(picture->size(), CV_8U);
  for (const int pixel : cluster.pixels) {
    mask.at<std::uint8_t>(pixel / picture->cols, pixel % picture->cols) = 255;
  }
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::Mat::ones(5, 5, CV_8U));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  cv::drawContours(*picture, contours, -1, color, 2, cv::LINE_AA);
  const cv::Rect box = cv::boundingRect(mask);
  DrawText(caption, {std::max(2, box.x), std::max(14, box.y - 6)}, color, picture);
}

}  // namespace

cv::Mat DrawView(const world::SceneBelief& belief, int view) {
  const world::Observation& observation = belief.views[view];
  cv::Mat picture = observation.frame.color.clone();
  for (const world::ObjectBelief& object : belief.objects) {
    for (const world::Sighting& sighting : object.sightings) {
      if (sighting.view != view) continue;
      DrawThing(observation.detections[sighting.detection].cluster, Caption(object),
                ColorOf(object.state), &picture);
    }
  }
  return picture;
}

}  // namespace secondlook::apps
