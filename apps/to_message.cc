#include "apps/to_message.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/deflate.h"
#include "lib/fusion/dempster_shafer.h"

namespace secondlook::apps {
namespace {

constexpr std::size_t kMaxHypothesesPerDetection = 5;
constexpr std::size_t kMaxHypothesesPerObject = 8;
/// A reason longer than this tells nobody anything.
constexpr std::size_t kMaxReason = 400;
/// Outlines are simplified by so much.
constexpr double kContour_px = 1.0;
/// Classes below this are not listed.
constexpr double kMinProbability = 1e-4;

std::string Shortened(const std::string& text) {
  std::string shortened = text;
  if (text.size() > kMaxReason) shortened.replace(kMaxReason, std::string::npos, "...");
  return shortened;
}

template <std::size_t N>
void Copy(const Eigen::Matrix<double, N, 1>& from, double (&to)[N]) {
  std::copy_n(from.data(), N, to);
}

std::vector<double> ToList(const Pose2& X_AB) { return {X_AB.x, X_AB.y, X_AB.yaw}; }

using apps::ToMessage;  // beside these

second_look::joint_knot_t ToMessage(const hal::JointKnot& knot) {
  second_look::joint_knot_t message{};
  message.seconds = knot.seconds;
  message.num_joints = static_cast<std::int32_t>(knot.q.size());
  message.q.assign(knot.q.begin(), knot.q.end());
  message.v.assign(knot.v.begin(), knot.v.end());
  return message;
}

second_look::hypothesis_t ToMessage(const world::Hypothesis& hypothesis) {
  second_look::hypothesis_t message{};
  message.model = hypothesis.model;
  message.X_CM = ToMessage(hypothesis.X_CM);
  message.score = hypothesis.score;
  message.verification = ToMessage(hypothesis.verification);
  return message;
}

second_look::pose_hypothesis_t ToMessage(const world::PoseHypothesis& hypothesis) {
  second_look::pose_hypothesis_t message{};
  message.model = hypothesis.model;
  message.X_WM = ToMessage(hypothesis.X_WM);
  message.support = hypothesis.support;
  message.struck = hypothesis.struck;
  message.reason = Shortened(hypothesis.reason);
  for (const world::ViewEvidence& e : hypothesis.evidence) {
    message.evidence.push_back({});
    message.evidence.back().view = e.view;
    message.evidence.back().score = e.hypothesis.score;
    message.evidence.back().verification = ToMessage(e.hypothesis.verification);
  }
  message.num_evidence = static_cast<std::int32_t>(message.evidence.size());
  return message;
}

std::vector<second_look::class_probability_t> Posterior(const world::MassFunction& masses) {
  std::vector<second_look::class_probability_t> posterior;
  const auto add = [&](const std::string& name, double probability) {
    posterior.push_back({});
    posterior.back().name = name;
    posterior.back().probability = probability;
  };
  for (const auto& [c, mass] : masses.singletons) {
    const double belief = fusion::NormalisedBelief(masses, c);
    if (belief >= kMinProbability) add(c, belief);
  }
  add("unknown", fusion::NormalisedIgnorance(masses));
  return posterior;
}

/// Outline of the largest part of a cluster's mask, and the box around all of it.
void Outline(const world::Cluster& cluster, const cv::Size& size,
             second_look::detection_t* message) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8U);
  for (const int pixel : cluster.pixels) {
    mask.at<std::uint8_t>(pixel / size.width, pixel % size.width) = 255;
  }
  const cv::Rect box = cv::boundingRect(mask);
  message->box[0] = box.x;
  message->box[1] = box.y;
  message->box[2] = box.width;
  message->box[3] = box.height;
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::Mat::ones(5, 5, CV_8U));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  if (contours.empty()) return;
  const auto& largest = *std::max_element(
      contours.begin(), contours.end(),
      [](const auto& a, const auto& b) { return cv::contourArea(a) < cv::contourArea(b); });
  std::vector<cv::Point> simple;
  cv::approxPolyDP(largest, simple, kContour_px, true);
  for (const cv::Point& p : simple) {
    message->contour.push_back({static_cast<std::int16_t>(p.x), static_cast<std::int16_t>(p.y)});
  }
  message->num_contour = static_cast<std::int32_t>(message->contour.size());
}

bot_core::image_t ToImage(std::int64_t utime, const cv::Size& size, int row_stride,
                          std::int32_t format, std::vector<std::uint8_t> data) {
  bot_core::image_t image{};
  image.utime = utime;
  image.width = size.width;
  image.height = size.height;
  image.row_stride = row_stride;
  image.pixelformat = format;
  image.size = static_cast<std::int32_t>(data.size());
  image.data = std::move(data);
  image.nmetadata = 0;
  return image;
}

/// Every second pixel of every second row, in millimetres; 0 = none.
cv::Mat HalfDepth_mm(const cv::Mat& depth) {
  cv::Mat half(depth.rows / 2, depth.cols / 2, CV_16UC1);
  for (int v = 0; v < half.rows; ++v) {
    for (int u = 0; u < half.cols; ++u) {
      const double depth_mm = 1000.0 * depth.at<float>(2 * v, 2 * u);
      half.at<std::uint16_t>(v, u) = depth_mm > 0.0 && depth_mm < 65535.0
                                         ? static_cast<std::uint16_t>(std::lround(depth_mm))
                                         : 0;
    }
  }
  return half;
}

bot_core::image_t ToJpeg(std::int64_t utime, const cv::Mat& color, std::size_t max_bytes) {
  cv::Mat bgr;
  cv::cvtColor(color, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> jpeg;
  for (int quality = 80; quality > 0; quality -= 10) {
    cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality});
    if (jpeg.size() <= max_bytes) break;
  }
  return ToImage(utime, color.size(), 0, bot_core::image_t::PIXEL_FORMAT_MJPEG, std::move(jpeg));
}

}  // namespace

std::int64_t ToUtime(Time time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
}

second_look::pose_t ToMessage(const Pose& X_AB) {
  Eigen::Quaterniond q(X_AB.linear());
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  second_look::pose_t message{};
  Copy<3>(X_AB.translation(), message.p);
  Copy<4>(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), message.q);
  return message;
}

second_look::camera_t ToMessage(const std::string& name, const hal::CameraModel& camera) {
  second_look::camera_t message{};
  message.name = name;
  message.width = camera.width;
  message.height = camera.height;
  message.fx = camera.fx;
  message.fy = camera.fy;
  message.cx = camera.cx;
  message.cy = camera.cy;
  std::fill_n(message.distortion, 5, 0.0);  // frames come undistorted
  return message;
}

second_look::verification_t ToMessage(const world::Verification& v) {
  second_look::verification_t message{};
  message.rendered = v.rendered;
  message.visible = v.visible;
  message.matching = v.matching;
  message.see_through = v.see_through;
  message.quality = v.quality;
  message.visible_fraction = v.visible_fraction;
  message.color_agreement = v.color_agreement;
  message.accepted = v.accepted;
  message.reason = Shortened(v.reason);
  return message;
}

second_look::object_t ToMessage(const world::ObjectBelief& object) {
  const bool verified = object.state == world::ObjectState::kVerified;
  const world::PoseHypothesis* best = object.Best();
  second_look::object_t message{};
  message.id = object.id;
  message.state = ToString(object.state);
  message.class_name = object.state == world::ObjectState::kUnknown      ? "unknown"
                       : object.state == world::ObjectState::kClassified ? object.LeadingClass()
                       : best == nullptr                                 ? ""
                                                                         : best->model;
  message.reason = Shortened(object.reason);
  message.posterior = Posterior(object.masses);
  message.num_posterior = static_cast<std::int32_t>(message.posterior.size());
  message.omega = object.masses.omega;
  message.conflict = object.masses.conflict;
  Copy<3>(object.extent_W.center(), message.p_WO);
  Copy<3>(object.extent_W.sizes(), message.extent);
  message.has_pose = verified;
  message.X_WM = ToMessage(verified ? best->X_WM : Pose::Identity());
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) message.covariance[i][j] = verified ? best->covariance(i, j) : 0.0;
  }
  message.model = verified ? best->model : "";
  message.views = static_cast<std::int32_t>(object.sightings.size());
  message.looks_taken = object.looks_taken;
  for (const world::PoseHypothesis& h : object.hypotheses) {
    if (message.hypotheses.size() == kMaxHypothesesPerObject) break;
    message.hypotheses.push_back(ToMessage(h));
  }
  message.num_hypotheses = static_cast<std::int32_t>(message.hypotheses.size());
  return message;
}

second_look::support_plane_t ToMessage(const world::SupportPlane& plane_W) {
  second_look::support_plane_t message{};
  Copy<3>(plane_W.normal_A, message.normal_W);
  message.offset = plane_W.offset;
  for (std::size_t i = 0; i < plane_W.corners_A.size(); ++i) {
    Copy<3>(plane_W.corners_A[i], message.corners_W[i]);
  }
  return message;
}

second_look::look_t ToMessage(const world::Look& look) {
  second_look::look_t message{};
  message.kind = look.kind;
  message.target = look.target;
  message.way = ToString(look.way);
  for (const hal::JointKnot& knot : look.arm_motion.knots) {
    message.arm_knots.push_back(ToMessage(knot));
  }
  message.num_arm_knots = static_cast<std::int32_t>(message.arm_knots.size());
  Copy<3>(Eigen::Vector3d(look.X_WB.x, look.X_WB.y, look.X_WB.yaw), message.X_WB);
  message.head[0] = look.head.pan;
  message.head[1] = look.head.tilt;
  message.X_WC = ToMessage(look.X_WC);
  for (const Pose2& waypoint : look.path_W) message.path_W.push_back(ToList(waypoint));
  message.num_path = static_cast<std::int32_t>(message.path_W.size());
  for (const world::LookCheck& check : look.checks) {
    message.checks.push_back({});
    message.checks.back().name = check.name;
    message.checks.back().passed = check.passed;
    message.checks.back().detail = Shortened(check.detail);
  }
  message.num_checks = static_cast<std::int32_t>(message.checks.size());
  message.feasible = look.feasible;
  for (const auto& [name, value] :
       {std::pair("visibility", look.visibility), std::pair("gain", look.gain)}) {
    message.terms.push_back({});
    message.terms.back().name = name;
    message.terms.back().value = value;
  }
  message.num_terms = static_cast<std::int32_t>(message.terms.size());
  message.score = look.score;
  message.seconds = look.seconds;
  message.metres = look.metres;
  message.chosen = look.chosen;
  message.reason = Shortened(look.reason);
  return message;
}

second_look::task_t ToMessage(const world::Task& task) {
  second_look::task_t message{};
  message.utime = 0;
  for (const auto& [name, confidence] : task.wanted) {
    message.wanted.push_back({});
    message.wanted.back().name = name;
    message.wanted.back().confidence = confidence;
  }
  message.num_wanted = static_cast<std::int32_t>(message.wanted.size());
  message.confidence = task.confidence;
  message.budget_looks = task.budget.looks;
  message.budget_seconds = task.budget.seconds;
  message.budget_metres = task.budget.metres;
  return message;
}

world::Task FromMessage(const second_look::task_t& message) {
  world::Task task;
  for (const second_look::wanted_t& wanted : message.wanted) {
    task.wanted[wanted.name] = wanted.confidence;
  }
  task.confidence = message.confidence;
  task.budget.looks = message.budget_looks;
  task.budget.seconds = message.budget_seconds;
  task.budget.metres = message.budget_metres;
  return task;
}

world::Look FromMessage(const second_look::look_t& message) {
  world::Look look;
  look.kind = message.kind;
  look.target = message.target;
  look.way = world::ParseLookWay(message.way);
  for (const second_look::joint_knot_t& knot : message.arm_knots) {
    look.arm_motion.knots.push_back(
        {knot.seconds, Eigen::Map<const Eigen::VectorXd>(knot.q.data(), std::ssize(knot.q)),
         Eigen::Map<const Eigen::VectorXd>(knot.v.data(), std::ssize(knot.v))});
  }
  look.X_WB = {message.X_WB[0], message.X_WB[1], message.X_WB[2]};
  look.head = {message.head[0], message.head[1]};
  look.X_WC.translation() = Eigen::Map<const Eigen::Vector3d>(message.X_WC.p);
  const double* q = message.X_WC.q;
  look.X_WC.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  for (const std::vector<double>& waypoint : message.path_W) {
    look.path_W.push_back({waypoint[0], waypoint[1], waypoint[2]});
  }
  for (const second_look::look_check_t& check : message.checks) {
    look.checks.push_back({check.name, check.passed != 0, check.detail});
  }
  look.feasible = message.feasible != 0;
  for (const second_look::score_term_t& term : message.terms) {
    if (term.name == "visibility") look.visibility = term.value;
    if (term.name == "gain") look.gain = term.value;
  }
  look.seconds = message.seconds;
  look.metres = message.metres;
  look.score = message.score;
  look.chosen = message.chosen != 0;
  look.reason = message.reason;
  return look;
}

std::vector<second_look::detection_t> DetectionsOf(const world::SceneBelief& belief, int view) {
  const world::Observation& observation = belief.views[view];
  std::vector<second_look::detection_t> messages;
  for (std::size_t i = 0; i < observation.detections.size(); ++i) {
    const world::Detection& detection = observation.detections[i];
    second_look::detection_t& message = messages.emplace_back();
    message.object_id = -1;
    for (const world::ObjectBelief& object : belief.objects) {
      for (const world::Sighting& s : object.sightings) {
        if (s.view == view && s.detection == static_cast<int>(i)) message.object_id = object.id;
      }
    }
    message.num_contour = 0;
    Outline(detection.cluster, observation.frame.depth.size(), &message);
    message.points = static_cast<std::int32_t>(detection.cluster.pixels.size());
    Copy<3>(observation.X_WC * detection.cluster.center_C, message.center_W);
    message.touches_border = detection.cluster.touches_border;
    message.reason = Shortened(detection.reason);
    for (const world::Hypothesis& h : detection.hypotheses) {
      if (message.hypotheses.size() == kMaxHypothesesPerDetection) break;
      message.hypotheses.push_back(ToMessage(h));
    }
    message.num_hypotheses = static_cast<std::int32_t>(message.hypotheses.size());
  }
  return messages;
}

bot_core::images_t ToImages(const hal::RgbdFrame& frame, std::size_t max_bytes) {
  const std::int64_t utime = ToUtime(frame.time);
  bot_core::images_t images{};
  images.utime = utime;
  std::size_t depth_bytes = 0;
  if (!frame.depth.empty()) {
    const cv::Mat depth_mm = HalfDepth_mm(frame.depth);
    images.images.push_back(ToImage(utime, depth_mm.size(), 2 * depth_mm.cols,
                                    bot_core::image_t::PIXEL_FORMAT_LE_GRAY16,
                                    Deflate({depth_mm.data, depth_mm.total() * 2})));
    images.image_types.push_back(bot_core::images_t::DEPTH_MM_ZIPPED);
    depth_bytes = images.images.back().data.size();
  }
  constexpr std::size_t kRest = 1000;  // all that is neither
  const std::size_t left = max_bytes - std::min(max_bytes, depth_bytes + kRest);
  images.images.push_back(ToJpeg(utime, frame.color, left));
  images.image_types.push_back(bot_core::images_t::LEFT);
  images.n_images = static_cast<std::int32_t>(images.images.size());
  return images;
}

}  // namespace secondlook::apps
