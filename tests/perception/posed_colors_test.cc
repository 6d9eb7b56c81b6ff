#include "lib/perception/posed_colors.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

/// A plank on z = 0 whose broad sides (-y and y) have a grain: vertices 5 mm apart, each as grey as
/// `contrast` and an own number between -1 and 1 say.
world::ObjectModel MakePlank(float contrast) {
  constexpr int kColumns = 24;
  constexpr int kRows = 32;
  constexpr float kStep = 0.005F;
  Rng rng(3);
  world::ObjectModel plank;
  plank.name = "plank";
  geometry::Mesh& mesh = plank.mesh;
  for (const float y : {-0.02F, 0.02F}) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (int row = 0; row <= kRows; ++row) {
      for (int column = 0; column <= kColumns; ++column) {
        const float x = kStep * static_cast<float>(column - kColumns / 2);
        mesh.vertices.emplace_back(x, y, kStep * static_cast<float>(row));
        const float grey = 0.5F + contrast * static_cast<float>(rng.Uniform(-1.0, 1.0));
        mesh.vertex_colors.emplace_back(grey, grey, grey);
      }
    }
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const int at = first + row * (kColumns + 1) + column;
        mesh.triangles.emplace_back(at, at + 1, at + kColumns + 1);
        mesh.triangles.emplace_back(at + 1, at + kColumns + 2, at + kColumns + 1);
      }
    }
  }
  mesh.materials.emplace_back();
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  return plank;
}

/// A plank, seen at an angle, and turned by half about its upright axis.
class Plank {
 public:
  explicit Plank(float contrast) : model_(TrainModel(MakePlank(contrast))) {
    Rng rng(1);
    const Pose X_WM = Upright(0.0, 0.0, 0.3);
    scene_ = DrawView({{&model_, X_WM}}, -std::numbers::pi / 2, true, &rng);
    X_CM_ = scene_.X_WC.inverse() * X_WM;
    X_CM_turned_ = X_CM_ * Upright(0.0, 0.0, std::numbers::pi);
  }

  PosedColors True() const { return {model_, X_CM_, scene_.view}; }
  PosedColors Turned() const { return {model_, X_CM_turned_, scene_.view}; }
  /// A pixel and a half aside: half a step of the grain.
  PosedColors Off() const {
    const Pose X_CM = Pose(Eigen::Translation3d(0.0026, 0.0, 0.0)) * X_CM_;
    return {model_, X_CM, scene_.view};
  }
  PosedColors Beside() const {
    const Pose X_CM = Pose(Eigen::Translation3d(0.3, 0.0, 0.0)) * X_CM_;
    return {model_, X_CM, scene_.view};
  }
  void ForgetColor() { scene_.view.color = cv::Mat(); }

 private:
  RecognitionModel model_;
  SyntheticView scene_;
  Pose X_CM_;
  Pose X_CM_turned_;
};

TEST(PosedColors, AreLikelierWhereAFaintGrainLiesAsItWasSeen) {
  const Plank plank(0.06F);  // one sixteenth of black to white
  EXPECT_GT(plank.True().LogRatio(plank.Turned()).value(), 5.0);
}

TEST(PosedColors, AreAsMuchLikelierAsTheOthersAreLess) {
  const Plank plank(0.06F);
  EXPECT_NEAR(plank.True().LogRatio(plank.Turned()).value(),
              -plank.Turned().LogRatio(plank.True()).value(), 1e-9);
  EXPECT_EQ(plank.True().LogRatio(plank.True()).value(), 0.0);
}

TEST(PosedColors, AreLikelierAtAPoseAPixelOffThanAtOneTurnedByHalf) {
  const Plank plank(0.06F);
  EXPECT_GT(plank.Off().LogRatio(plank.Turned()).value(), 4.0);
}

TEST(PosedColors, AreUndecidedWhereAPlainThingLooksTheSame) {
  const Plank plank(0.0F);
  EXPECT_NEAR(plank.True().LogRatio(plank.Turned()).value(), 0.0, 1.0);
}

TEST(PosedColors, SayNothingOfPosesThatShareNoPixelOrOfAPictureWithoutColour) {
  Plank plank(0.06F);
  EXPECT_FALSE(plank.True().LogRatio(plank.Beside()).has_value());
  plank.ForgetColor();
  EXPECT_FALSE(plank.True().LogRatio(plank.Turned()).has_value());
}

}  // namespace
}  // namespace secondlook::perception
