#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/mesh.h"
#include "sim/render.h"

namespace secondlook::sim {

/// A lamp that shines in all directions, as bright near as far.
struct Light {
  Eigen::Vector3d position{0.0, 0.0, 2.5};  ///< In W [m].
  Eigen::Vector3d color{1.0, 1.0, 1.0};     ///< RGB, 1 = white.
  double intensity{0.8};                    ///< Of the light on a surface that faces it.

  template <class A>
  void Serialize(A* a) {
    a->Visit("position", &position);
    a->Visit("color", &color);
    a->Visit("intensity", &intensity);
  }
};

/// All the light in a scene.
struct Lighting {
  std::vector<Light> lights;              ///< At most kMaxLights.
  double ambient{0.35};                   ///< From everywhere; a little less from below.
  Eigen::Vector3d focus{0.0, 0.0, 0.75};  ///< In W [m]; things cast shadows …
  double focus_radius{1.0};               ///< … within this distance [m] of it.

  static constexpr std::size_t kMaxLights = 8;
};

/// A mesh at a place.
struct Instance {
  int mesh{};                   ///< What Renderer::AddMesh returned.
  Pose X_WM{Pose::Identity()};  ///< Where it stands.
  int id{};                     ///< In [1, 65535], not necessarily unique.
};

/// Draws meshes off-screen with OpenGL 3.3 on the processor (OSMesa); needs no display. Each
/// renderer has a context of its own, so that several work side by side, in one thread or many;
/// one renderer belongs to one thread at a time.
class Renderer {
 public:
  /// @throws InvalidArgument for an invalid model or too many lights; Error when OpenGL fails.
  Renderer(const geometry::CameraModel& model, const Lighting& lighting);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const geometry::CameraModel& model() const;

  /// Takes a copy of `mesh` and returns its number. Edges sharper than 40 degrees stay edges, the
  /// rest is shaded smoothly. @pre !mesh.empty().
  int AddMesh(const geometry::Mesh& mesh);

  /// What a camera at `X_WC` sees of `instances` from 5 cm to 50 m. Both sides of a triangle are
  /// drawn: meshes need not be closed.
  Render Draw(const Pose& X_WC, const std::vector<Instance>& instances);

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
};

}  // namespace secondlook::sim
