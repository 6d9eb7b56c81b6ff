#include "lib/kinematics/calibrate_head.h"

#include <algorithm>
#include <numbers>

#include "lib/common/error.h"

namespace secondlook::kinematics {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kMinViews = 5;
constexpr double kMinSpread = 10.0 * kDegree;

void RequireSpread(const std::vector<BoardView>& views) {
  if (views.size() < kMinViews) {
    Throw<InvalidArgument>(
        "the board was found in {} views, at least {} are needed: light it well, and let it fill a "
        "third of the image",
        views.size(), kMinViews);
  }
  const auto spread = [&](double HeadAngles::*angle) {
    const auto [least, most] = std::minmax_element(
        views.begin(), views.end(),
        [&](const auto& a, const auto& b) { return a.head.*angle < b.head.*angle; });
    return most->head.*angle - least->head.*angle;
  };
  const double pan = spread(&HeadAngles::pan);
  const double tilt = spread(&HeadAngles::tilt);
  if (pan < kMinSpread || tilt < kMinSpread) {
    Throw<InvalidArgument>(
        "the views of the board differ by {:.1f} deg of pan and {:.1f} deg of tilt, which does not "
        "tell where the camera sits; {:.0f} deg of both do: put the board farther away, so that it "
        "stays in view",
        pan / kDegree, tilt / kDegree, kMinSpread / kDegree);
  }
}

}  // namespace

Calibration CalibrateHead(const std::vector<BoardView>& views, const geometry::CameraModel& camera,
                          const HeadCalibration& nominal, double encoder_sigma) {
  RequireSpread(views);
  std::vector<CarriedView> carried;
  for (const BoardView& view : views) {
    carried.push_back(
        {view.board, [head = view.head](const Eigen::VectorXd& error) {
           return CameraInBase(HeadCalibration{}, {head.pan + error[0], head.tilt + error[1]});
         }});
  }
  // In the frame H0 instead of the base's.
  CarriedCamera start;
  start.X_EC = nominal.X_HC;
  start.X_BP =
      CameraInBase({Pose::Identity(), nominal.X_HC}, views.front().head) * views.front().board.X_CP;
  const CarriedCamera found =
      CalibrateCarriedCamera(carried, camera, start, Eigen::Vector2d::Constant(encoder_sigma));
  return {{nominal.X_BH0, found.X_EC},
          {},
          CalibrationResiduals{static_cast<int>(views.size()), found.pixels, 1e3 * found.metres,
                               found.radians / kDegree}};
}

}  // namespace secondlook::kinematics
