// Depth renders as verification needs them: 64 x 64 pixels, a mesh of 9,068 triangles, one thread,
// against OSMesa and a plain z-buffer. First the gate: over all poses the depth must be equal to
// OSMesa's at 1 mm on 99.5 % of the union of the silhouettes; the status is 1 when it is not.
//   verification_renders [--benchmark_…]
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "lib/common/rng.h"
#include "lib/geometry/depth_rasteriser.h"

namespace secondlook::bench {
namespace {

constexpr int kSize = 64;  // [px]
constexpr int kPoses = 64;
constexpr float kNear = 0.2F;  // [m]
constexpr float kFar = 2.0F;   // [m]
const geometry::CameraModel kCamera{kSize, kSize, 150.0, 150.0, 31.5, 31.5};
const geometry::PixelRect kWindow{0, 0, kSize, kSize};

/// A power drill that lies on a box of tea.
const geometry::Mesh& TheMesh() {
  static const geometry::Mesh mesh = [] {
    geometry::Mesh both =
        geometry::LoadMesh("sim/models/tea_box/mesh.obj", geometry::LengthUnit::kMetre);
    const geometry::Mesh drill =
        geometry::LoadMesh("sim/models/power_drill/mesh.obj", geometry::LengthUnit::kMetre);
    const auto first = static_cast<int>(both.vertices.size());
    const auto top = static_cast<float>(geometry::Bounds(both).max().z());
    for (const Eigen::Vector3f& v : drill.vertices) {
      both.vertices.push_back(v + Eigen::Vector3f(0.0F, 0.0F, top));
    }
    for (const Eigen::Vector3i& t : drill.triangles) both.triangles.push_back(t.array() + first);
    return both;
  }();
  return mesh;
}

/// Turned at random, 56 pixels large.
const std::vector<Pose>& ThePoses() {
  static const std::vector<Pose> poses = [] {
    Rng rng(1);
    const Eigen::Vector3d center = geometry::Bounds(TheMesh()).center();
    std::vector<Pose> drawn(kPoses, Pose::Identity());
    for (Pose& X_CM : drawn) {
      X_CM.linear() = Eigen::Quaterniond(rng.Gaussian(1.0), rng.Gaussian(1.0), rng.Gaussian(1.0),
                                         rng.Gaussian(1.0))
                          .normalized()
                          .toRotationMatrix();
      const double distance = geometry::Diameter(TheMesh()) * kCamera.fx / 56.0;
      X_CM.translation() = Eigen::Vector3d(0.0, 0.0, distance) - X_CM.linear() * center;
    }
    return drawn;
  }();
  return poses;
}

/// What one would write first: every triangle in turn, every pixel of its bounding box.
class PlainZBuffer {
 public:
  const std::vector<float>& Render(const geometry::Mesh& mesh, const Pose& X_CM) {
    depth_.assign(kSize * kSize, std::numeric_limits<float>::quiet_NaN());
    points_.clear();
    for (const Eigen::Vector3f& v : mesh.vertices) {
      const Eigen::Vector3f p = (X_CM * v.cast<double>()).cast<float>();
      points_.emplace_back(static_cast<float>(kCamera.fx) * p.x() / p.z() + 31.5F,
                           static_cast<float>(kCamera.fy) * p.y() / p.z() + 31.5F, 1.0F / p.z());
    }
    for (const Eigen::Vector3i& t : mesh.triangles) {
      Draw(points_[static_cast<std::size_t>(t[0])], points_[static_cast<std::size_t>(t[1])],
           points_[static_cast<std::size_t>(t[2])]);
    }
    return depth_;
  }

 private:
  void Draw(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    const Eigen::Vector3f low = a.cwiseMin(b).cwiseMin(c);
    const Eigen::Vector3f high = a.cwiseMax(b).cwiseMax(c);
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0F) return;
    for (int y = std::max(0, static_cast<int>(std::ceil(low.y())));
         y <= std::min(kSize - 1, static_cast<int>(std::floor(high.y()))); ++y) {
      for (int x = std::max(0, static_cast<int>(std::ceil(low.x())));
           x <= std::min(kSize - 1, static_cast<int>(std::floor(high.x()))); ++x) {
        const float dx = static_cast<float>(x) - a.x();
        const float dy = static_cast<float>(y) - a.y();
        const float wb = ((c.y() - a.y()) * dx - (c.x() - a.x()) * dy) / area;
        const float wc = ((b.x() - a.x()) * dy - (b.y() - a.y()) * dx) / area;
        if (wb < 0.0F || wc < 0.0F || wb + wc > 1.0F) continue;
        const float z = 1.0F / (a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z()));
        float& nearest = depth_[static_cast<std::size_t>(y * kSize + x)];
        if (!(nearest <= z)) nearest = z;
      }
    }
  }

  std::vector<Eigen::Vector3f> points_;  // column, row, 1/z
  std::vector<float> depth_;
};

/// Depth alone, from buffers that lie in the context, read back.
class OsMesa {
 public:
  explicit OsMesa(const geometry::Mesh& mesh)
      : context_(OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, nullptr)),
        color_(kSize * kSize),
        depth_(kSize * kSize),
        count_(static_cast<GLsizei>(3 * mesh.triangles.size())) {
    if (context_ == nullptr ||
        OSMesaMakeCurrent(context_, color_.data(), GL_UNSIGNED_BYTE, kSize, kSize) == GL_FALSE) {
      fmt::print("OSMesa cannot make a context\n");
      std::exit(1);
    }
    GLuint buffers[2];
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Eigen::Vector3f)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(Eigen::Vector3i)),
                 mesh.triangles.data(), GL_STATIC_DRAW);
    glEnableClientState(GL_VERTEX_ARRAY);
    glVertexPointer(3, GL_FLOAT, 0, nullptr);
    glEnable(GL_DEPTH_TEST);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glViewport(0, 0, kSize, kSize);
    // The camera model as a projection; rows go up in OpenGL, which only turns the picture over.
    Eigen::Matrix4f projection = Eigen::Matrix4f::Zero();
    projection(0, 0) = static_cast<float>(2.0 * kCamera.fx / kSize);
    projection(0, 2) = static_cast<float>(2.0 * (kCamera.cx + 0.5) / kSize - 1.0);
    projection(1, 1) = static_cast<float>(2.0 * kCamera.fy / kSize);
    projection(1, 2) = static_cast<float>(2.0 * (kCamera.cy + 0.5) / kSize - 1.0);
    projection(2, 2) = (kFar + kNear) / (kFar - kNear);
    projection(2, 3) = -2.0F * kFar * kNear / (kFar - kNear);
    projection(3, 2) = 1.0F;
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(projection.data());
    glMatrixMode(GL_MODELVIEW);
  }
  ~OsMesa() { OSMesaDestroyContext(context_); }
  OsMesa(const OsMesa&) = delete;
  OsMesa& operator=(const OsMesa&) = delete;

  /// Depth as OpenGL keeps it, in [0, 1]; 1: nothing.
  const std::vector<float>& Render(const Pose& X_CM) {
    const Eigen::Matrix4f model = X_CM.matrix().cast<float>();
    glClear(GL_DEPTH_BUFFER_BIT);
    glLoadMatrixf(model.data());
    glDrawElements(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr);
    glReadPixels(0, 0, kSize, kSize, GL_DEPTH_COMPONENT, GL_FLOAT, depth_.data());
    return depth_;
  }

 private:
  OSMesaContext context_;
  std::vector<std::uint32_t> color_;
  std::vector<float> depth_;
  GLsizei count_;
};

/// The share of the union of the silhouettes where the two depths are equal at 1 mm.
bool Agree() {
  OsMesa peer(TheMesh());
  PlainZBuffer plain;
  geometry::DepthRasteriser ours;
  int equal = 0;
  int plain_equal = 0;
  int either = 0;
  for (const Pose& X_CM : ThePoses()) {
    const std::vector<float>& theirs = peer.Render(X_CM);
    const std::vector<float>& second = plain.Render(TheMesh(), X_CM);
    ours.Render(TheMesh(), X_CM, kCamera, kWindow);
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      const float z = ours.depth()[i];
      const bool drawn = theirs[i] < 1.0F;
      if (!drawn && std::isnan(z)) continue;
      ++either;
      const float peer_z = kFar * kNear / (kFar - theirs[i] * (kFar - kNear));
      equal += drawn && std::abs(z - peer_z) <= 0.001F ? 1 : 0;
      plain_equal += drawn && std::abs(second[i] - peer_z) <= 0.001F ? 1 : 0;
    }
  }
  fmt::print(
      "{} triangles, {} poses, {} pixels: equal to OSMesa at 1 mm: ours {:.3f} %, plain "
      "z-buffer {:.3f} %\n",
      TheMesh().triangles.size(), ThePoses().size(), either, 100.0 * equal / either,
      100.0 * plain_equal / either);
  return equal >= 0.995 * either;
}

void Ours(benchmark::State& state) {
  geometry::DepthRasteriser rasteriser;
  std::size_t i = 0;
  for (auto _ : state) {
    rasteriser.Render(TheMesh(), ThePoses()[i++ % kPoses], kCamera, kWindow);
    benchmark::DoNotOptimize(rasteriser.depth().data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Ours)->Unit(benchmark::kMicrosecond);

void PlainZBufferRenders(benchmark::State& state) {
  PlainZBuffer plain;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(plain.Render(TheMesh(), ThePoses()[i++ % kPoses]).data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(PlainZBufferRenders)->Unit(benchmark::kMicrosecond);

void OsMesaRenders(benchmark::State& state) {
  OsMesa peer(TheMesh());
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(peer.Render(ThePoses()[i++ % kPoses]).data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(OsMesaRenders)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  setenv("LP_NUM_THREADS", "0", 1);  // one thread, which is also the faster for small pictures
  benchmark::Initialize(&argc, argv);
  if (!secondlook::bench::Agree()) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
