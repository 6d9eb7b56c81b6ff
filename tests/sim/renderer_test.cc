#include "sim/renderer.h"

#include <thread>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::sim {
namespace {

using Eigen::Vector3d;

constexpr geometry::CameraModel kModel{160, 120, 144.3, 144.3, 79.5, 59.5};
constexpr double kTolerance = 1e-4;  // [m]

/// A camera at the origin of W that looks along W's x axis.
Pose Forward() {
  Pose X_WC = Pose::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return X_WC;
}

Pose At(const Vector3d& p) {
  Pose X = Pose::Identity();
  X.translation() = p;
  return X;
}

Render DrawOne(const geometry::Mesh& mesh, const Pose& X_WM, const Pose& X_WC) {
  Renderer renderer(kModel, {.lights = {Light{}}, .ambient = 0.35});
  const int number = renderer.AddMesh(mesh);
  return renderer.Draw(X_WC, {{number, X_WM, 7}});
}

/// The depth of the nearest triangle along the ray through (u, v), by Moeller and Trumbore's
/// intersection in double precision; infinite when there is none. `margin` is the smallest
/// barycentric weight of the hit: near 0 the pixel lies on an edge and may show either side.
double TraceDepth(const geometry::Mesh& mesh, const Pose& X_CM, double u, double v,
                  double* margin) {
  const Vector3d ray = kModel.Ray(u, v);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d a = X_CM * mesh.vertices[t[0]].cast<double>();
    const Vector3d ab = X_CM * mesh.vertices[t[1]].cast<double>() - a;
    const Vector3d ac = X_CM * mesh.vertices[t[2]].cast<double>() - a;
    const Vector3d p = ray.cross(ac);
    const double determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-15) continue;
    const double b = -a.dot(p) / determinant;
    const Vector3d q = (-a).cross(ab);
    const double c = ray.dot(q) / determinant;
    const double z = ac.dot(q) / determinant;
    if (b < 0 || c < 0 || b + c > 1 || z <= 0 || z >= nearest) continue;
    nearest = z;
    *margin = std::min({b, c, 1 - b - c});
  }
  return nearest;
}

/// Compares every pixel whose ray hits well inside a triangle; returns how many.
int CompareWithTracing(const geometry::Mesh& mesh, const Pose& X_WM, const Pose& X_WC) {
  const Render render = DrawOne(mesh, X_WM, X_WC);
  int compared = 0;
  for (int v = 0; v < kModel.height; v += 3) {
    for (int u = 0; u < kModel.width; u += 3) {
      double margin = 0.0;
      const double z = TraceDepth(mesh, X_WC.inverse() * X_WM, u, v, &margin);
      if (std::isinf(z) || margin < 0.02) continue;
      EXPECT_NEAR(render.depth.at<float>(v, u), z, kTolerance) << "at " << u << ", " << v;
      EXPECT_EQ(render.id.at<std::uint16_t>(v, u), 7);
      ++compared;
    }
  }
  return compared;
}

TEST(Renderer, DepthOfAPlaneIsAnalytic) {
  // The plane x = 2 in W, 10 m wide, seen from a camera turned by 30 degrees about z: z(u, v) is
  // 2 over the x component in W of the pixel's ray.
  const geometry::Mesh plane = geometry::MakeBox({0.02, 10, 10}, {1, 1, 1});
  Pose X_WC = Forward();
  X_WC.prerotate(RotationFromRollPitchYaw(0, 0, 0.5));
  const Render render = DrawOne(plane, At({2.01, 0, 0}), X_WC);
  for (int v = 0; v < kModel.height; v += 7) {
    for (int u = 0; u < kModel.width; u += 7) {
      const Vector3d ray_W = X_WC.linear() * kModel.Ray(u, v);
      EXPECT_NEAR(render.depth.at<float>(v, u), 2.0 / ray_W.x(), kTolerance);
      EXPECT_NEAR(render.cos_incidence.at<float>(v, u), ray_W.normalized().x(), 1e-4);
    }
  }
}

TEST(Renderer, DepthOfAFloorThatReachesBehindTheCameraIsAnalytic) {
  const geometry::Mesh floor = geometry::MakeBox({8, 8, 0.02}, {1, 1, 1});
  Pose X_WC = Forward();
  X_WC.prerotate(RotationFromRollPitchYaw(0, 0.6, 0.3));
  X_WC.translation() = Vector3d(-1, 0.5, 1.25);
  const Render render = DrawOne(floor, At({0, 0, -0.01}), X_WC);
  for (int v = 0; v < kModel.height; v += 5) {
    for (int u = 0; u < kModel.width; u += 5) {
      const double down = (X_WC.linear() * kModel.Ray(u, v)).z();
      if (down > -0.3) continue;
      EXPECT_NEAR(render.depth.at<float>(v, u), -1.25 / down, kTolerance);
    }
  }
}

TEST(Renderer, DepthOfABoxIsThatOfItsTriangles) {
  Pose X_WM = At({1.2, 0.1, -0.1});
  X_WM.linear() = RotationFromRollPitchYaw(0.3, 0.5, 0.8);
  EXPECT_GT(CompareWithTracing(geometry::MakeBox({0.4, 0.5, 0.3}, {1, 1, 1}), X_WM, Forward()),
            300);
}

TEST(Renderer, DepthOfASphereIsThatOfItsTriangles) {
  EXPECT_GT(
      CompareWithTracing(geometry::MakeSphere(0.3, 30, {1, 1, 1}), At({1.0, 0, 0}), Forward()),
      300);
}

TEST(Renderer, DepthOfAFineSphereIsAnalytic) {
  const Render render =
      DrawOne(geometry::MakeSphere(0.3, 400, {1, 1, 1}), At({1.0, 0, 0}), Forward());
  // The chord of a triangle lies within 0.3 m (1 - cos(pi / 800)) = 2.3 um of the sphere.
  int compared = 0;
  for (int v = 0; v < kModel.height; v += 2) {
    for (int u = 0; u < kModel.width; u += 2) {
      const Vector3d ray = kModel.Ray(u, v);  // |z ray - (0, 0, 1)|^2 = 0.3^2, solved for z
      const double half_b = 1.0 / ray.squaredNorm();
      const double root = half_b * half_b - (1.0 - 0.09) / ray.squaredNorm();
      if (root < 0.01) continue;  // the outline
      EXPECT_NEAR(render.depth.at<float>(v, u), half_b - std::sqrt(root), kTolerance);
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

TEST(Renderer, ShowsNothingAsNanAndIdZero) {
  const Render render =
      DrawOne(geometry::MakeBox({0.1, 0.1, 0.1}, {1, 1, 1}), At({1, 0, 0}), Forward());
  EXPECT_TRUE(std::isnan(render.depth.at<float>(0, 0)));
  EXPECT_EQ(render.id.at<std::uint16_t>(0, 0), 0);
  EXPECT_NEAR(render.depth.at<float>(60, 80), 0.95, kTolerance);
}

TEST(Renderer, PutsTheTextureTheRightWayUpAndKeepsItsRgbOrder) {
  // A wall with an image whose upper left quarter is red, seen upright.
  geometry::Mesh wall;
  wall.vertices = {{0, 1, -1}, {0, -1, -1}, {0, -1, 1}, {0, 1, 1}};
  wall.uv = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.triangle_material = {0, 0};
  wall.materials.emplace_back();
  wall.materials[0].texture = cv::Mat(64, 64, CV_8UC3, cv::Scalar(0, 0, 255));
  wall.materials[0].texture(cv::Rect(0, 0, 32, 32)).setTo(cv::Scalar(255, 0, 0));
  Renderer renderer(kModel, {.lights = {}, .ambient = 1.0 / 0.85});
  const Render render = renderer.Draw(Forward(), {{renderer.AddMesh(wall), At({2, 0, 0}), 1}});
  EXPECT_EQ(render.color.at<cv::Vec3b>(30, 40), cv::Vec3b(255, 0, 0));
  EXPECT_EQ(render.color.at<cv::Vec3b>(30, 120), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(render.color.at<cv::Vec3b>(90, 40), cv::Vec3b(0, 0, 255));
  // Linear luminances of the primaries (ITU-R BT.709).
  EXPECT_NEAR(render.luminance.at<float>(30, 40), 0.2126, 1e-3);
  EXPECT_NEAR(render.luminance.at<float>(30, 120), 0.0722, 1e-3);
}

TEST(Renderer, EncodesLinearLightAsSrgb) {
  // A wall of base colour 128 in full ambient light shows as 128; in half, as the sRGB code of half
  // its linear value (0.2159 / 2 = 0.1079 -> 92.4).
  const geometry::Mesh wall =
      geometry::MakeBox({0.1, 3, 3}, Eigen::Vector3f::Constant(128 / 255.F));
  for (const auto& [share, expected] : {std::pair{1.0, 128}, std::pair{0.5, 92}}) {
    Renderer renderer(kModel, {.lights = {}, .ambient = share / 0.85});
    const Render render = renderer.Draw(Forward(), {{renderer.AddMesh(wall), At({2, 0, 0}), 1}});
    EXPECT_NEAR(render.color.at<cv::Vec3b>(60, 80)[1], expected, 1);
  }
}

TEST(Renderer, AShinySphereHasAHighlightThatADullOneHasNot) {
  geometry::Mesh sphere = geometry::MakeSphere(0.3, 60, {0.2F, 0.2F, 0.2F});
  const auto brightest = [&] {
    Renderer renderer(kModel, {.lights = {{.position = {0, 0, 1}}}, .ambient = 0.2});
    const Render r = renderer.Draw(Forward(), {{renderer.AddMesh(sphere), At({1, 0, 0}), 1}});
    int most = 0;
    for (int v = 20; v < 100; ++v) {
      for (int u = 40; u < 120; ++u) {
        if (r.id.at<std::uint16_t>(v, u) == 1)
          most = std::max<int>(most, r.color.at<cv::Vec3b>(v, u)[0]);
      }
    }
    return most;
  };
  const int dull = brightest();
  sphere.materials[0].specular = 0.8F;
  sphere.materials[0].shininess = 60.0F;
  EXPECT_GT(brightest(), dull + 100);
}

TEST(Renderer, WhatComesBetweenALampAndASurfaceCastsAShadowThatMovesWithIt) {
  // A lamp 3 m above (2, 0) and a plate 1 m above the floor; the camera sees the floor below the
  // plate past it, at the centre of the picture.
  Renderer renderer(kModel, {.lights = {{.position = {2, 0, 3}, .intensity = 0.5}},
                             .ambient = 0.2,
                             .focus = {2, 0, 0},
                             .focus_radius = 1.5});
  const Instance floor{renderer.AddMesh(geometry::MakeBox({8, 8, 0.02}, {1, 1, 1})),
                       At({0, 0, -0.01}), 1};
  Instance plate{renderer.AddMesh(geometry::MakeBox({0.3, 0.3, 0.01}, {1, 1, 1})), At({2, 0, 1}),
                 2};
  Pose X_WC = Forward();
  X_WC.prerotate(RotationFromRollPitchYaw(0, M_PI / 4, 0));
  X_WC.translation() = Vector3d(0, 0, 2);
  const auto brightness = [&](const std::vector<Instance>& instances) {
    const Render render = renderer.Draw(X_WC, instances);
    EXPECT_EQ(render.id.at<std::uint16_t>(60, 80), 1);
    return render.color.at<cv::Vec3b>(60, 80)[1];
  };
  // Linear light: 0.2 of the ambience, up to 0.5 of the lamp; sRGB codes 124 and 218 of 255.
  const int lit = brightness({floor});
  EXPECT_NEAR(lit, 218, 3);
  EXPECT_NEAR(brightness({floor, plate}), 124, 3);
  plate.X_WM = At({2, 1.0, 1});
  EXPECT_EQ(brightness({floor, plate}), lit);
}

TEST(Renderer, SeveralInOneProcessDoNotDisturbEachOther) {
  const geometry::Mesh box = geometry::MakeBox({0.4, 0.5, 0.3}, {1, 0.5F, 0.2F});
  const geometry::Mesh sphere = geometry::MakeSphere(0.3, 30, {0.1F, 0.5F, 0.2F});
  const Render alone = DrawOne(box, At({1, 0, 0}), Forward());
  const auto same = [](const cv::Mat& a, const cv::Mat& b) {
    return std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
  };
  const Lighting lighting{.lights = {Light{}}, .ambient = 0.35};
  Renderer first(kModel, lighting);
  const int in_first = first.AddMesh(box);
  Renderer second(kModel, lighting);
  const int in_second = second.AddMesh(sphere);
  second.Draw(Forward(), {{in_second, At({1, 0, 0}), 1}});
  const Render beside = first.Draw(Forward(), {{in_first, At({1, 0, 0}), 7}});
  EXPECT_TRUE(same(alone.color, beside.color));
  EXPECT_TRUE(same(alone.depth, beside.depth));

  std::vector<Render> renders(4);
  std::vector<std::thread> threads;
  for (Render& render : renders) {
    threads.emplace_back([&] { render = DrawOne(box, At({1, 0, 0}), Forward()); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Render& render : renders) {
    EXPECT_TRUE(same(alone.color, render.color));
    EXPECT_TRUE(same(alone.depth, render.depth));
  }
}

TEST(Renderer, RefusesMoreLightsThanItHas) {
  EXPECT_THROWS(Renderer(kModel, {.lights = std::vector<Light>(9), .ambient = 0.3}),
                InvalidArgument, "9 lights; a scene may have 8");
}

}  // namespace
}  // namespace secondlook::sim
