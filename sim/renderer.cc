#include "sim/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <GL/osmesa.h>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "sim/shaded_mesh.h"
#include "sim/shaders.h"

namespace secondlook::sim {
namespace {

constexpr double kNear = 0.05;                               // [m]
constexpr double kFar = 50.0;                                // [m]
constexpr double kCrease = 40.0 / 180.0 * std::numbers::pi;  // [rad]
constexpr int kShadowPixels = 512;                           // side of a shadow map
constexpr float kShadowSlopeBias = 2.0F;                     // glPolygonOffset's factor
constexpr float kShadowBias = 4.0F;                          // glPolygonOffset's units
constexpr float kBackground[3] = {0.75F, 0.78F, 0.80F};

/// Context creation initialises state that all contexts of the process share.
OSMesaContext CreateContext() {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  constexpr int kAttributes[] = {OSMESA_FORMAT,
                                 OSMESA_RGBA,
                                 OSMESA_DEPTH_BITS,
                                 0,
                                 OSMESA_PROFILE,
                                 OSMESA_CORE_PROFILE,
                                 OSMESA_CONTEXT_MAJOR_VERSION,
                                 3,
                                 OSMESA_CONTEXT_MINOR_VERSION,
                                 3,
                                 0};
  OSMesaContext context = OSMesaCreateContextAttribs(kAttributes, nullptr);
  if (context == nullptr)
    throw Error("OSMesa cannot make an OpenGL 3.3 context; is it 17 or later?");
  return context;
}

GLuint Compile(GLenum type, const char* source) {
  const GLuint shader = glCreateShader(type);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  Throw<Error>("OpenGL refuses the simulator's shader: {}", log.substr(0, length));
}

GLuint Link(const char* vertex_source, const char* fragment_source) {
  const GLuint program = glCreateProgram();
  const GLuint vertex = Compile(GL_VERTEX_SHADER, vertex_source);
  const GLuint fragment = Compile(GL_FRAGMENT_SHADER, fragment_source);
  glAttachShader(program, vertex);
  glAttachShader(program, fragment);
  glLinkProgram(program);
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  GLint ok = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE) throw Error("OpenGL cannot link the simulator's shaders");
  return program;
}

/// Takes p_C to clip space such that pixel (u, v) of the camera model becomes column u and row v
/// of the image as it is read back.
Eigen::Matrix4f Projection(const geometry::CameraModel& m) {
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 2.0 * m.fx / m.width;
  P(0, 2) = (2.0 * m.cx + 1.0) / m.width - 1.0;
  P(1, 1) = 2.0 * m.fy / m.height;
  P(1, 2) = (2.0 * m.cy + 1.0) / m.height - 1.0;
  P(2, 2) = (kFar + kNear) / (kFar - kNear);
  P(2, 3) = -2.0 * kFar * kNear / (kFar - kNear);
  P(3, 2) = 1.0;
  return P.cast<float>();
}

/// Takes p_W to the clip space of a camera in `light` that sees all within the focus.
Eigen::Matrix4d ShadowProjection(const Lighting& lighting, const Light& light) {
  const Eigen::Vector3d toward = lighting.focus - light.position;
  const double distance = std::max(toward.norm(), 1.1 * lighting.focus_radius);
  const Eigen::Vector3d forward =
      toward.norm() > 0.0 ? Eigen::Vector3d(toward.normalized()) : Eigen::Vector3d(0.0, 0.0, -1.0);
  Pose X_LW = Pose::Identity();
  X_LW.linear() = Eigen::Quaterniond::FromTwoVectors(forward, Eigen::Vector3d::UnitZ()).matrix();
  X_LW.translation() = -(X_LW.linear() * light.position);
  const double near = kNear;
  const double far = distance + 2.0 * lighting.focus_radius;
  const double half = std::tan(std::asin(lighting.focus_radius / distance));
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 1.0 / half;
  P(1, 1) = 1.0 / half;
  P(2, 2) = (far + near) / (far - near);
  P(2, 3) = -2.0 * far * near / (far - near);
  P(3, 2) = 1.0;
  return P * X_LW.matrix();
}

bool SamePlaces(const std::vector<Instance>& a, const std::vector<Instance>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.mesh == y.mesh && x.X_WM.matrix() == y.X_WM.matrix();
  });
}

GLuint MakeTexture(const cv::Mat& rgb) {
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  // Row 0 of the image is v = 1, and OpenGL's row 0 is v = 0.
  cv::Mat flipped;
  cv::flip(rgb, flipped, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8, flipped.cols, flipped.rows, 0, GL_RGB, GL_UNSIGNED_BYTE,
               flipped.data);
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

struct GlMaterial {
  Eigen::Vector3f base_color;  // linear
  float specular{};
  float shininess{};
  GLuint texture{};  // 0: none
};

struct GlMesh {
  GLuint vertex_array{};
  GLuint buffers[2]{};
  GLsizei index_count{};
  std::vector<MaterialRange> ranges;
  std::vector<GlMaterial> materials;
};

void DescribeVertices() {
  const auto attribute = [](GLuint location, int size, std::size_t offset) {
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(ShadedVertex),
                          reinterpret_cast<const void*>(offset));
  };
  attribute(0, 3, offsetof(ShadedVertex, position));
  attribute(1, 3, offsetof(ShadedVertex, normal));
  attribute(2, 2, offsetof(ShadedVertex, uv));
  attribute(3, 3, offsetof(ShadedVertex, color));
}

GlMesh Upload(const geometry::Mesh& mesh) {
  ShadedMesh shaded = Shade(mesh, kCrease);
  GlMesh out;
  glGenVertexArrays(1, &out.vertex_array);
  glBindVertexArray(out.vertex_array);
  glGenBuffers(2, out.buffers);
  glBindBuffer(GL_ARRAY_BUFFER, out.buffers[0]);
  glBufferData(GL_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(shaded.vertices.size() * sizeof(ShadedVertex)),
               shaded.vertices.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, out.buffers[1]);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(shaded.indices.size() * sizeof(std::uint32_t)),
               shaded.indices.data(), GL_STATIC_DRAW);
  DescribeVertices();
  out.index_count = static_cast<GLsizei>(shaded.indices.size());
  out.ranges = std::move(shaded.ranges);
  for (const geometry::Material& material : mesh.materials) {
    const bool textured = !material.texture.empty() && !mesh.uv.empty();
    out.materials.push_back({material.base_color.unaryExpr(&LinearFromSrgb), material.specular,
                             material.shininess, textured ? MakeTexture(material.texture) : 0});
  }
  return out;
}

}  // namespace

struct Renderer::Gl {
  geometry::CameraModel model;
  Lighting lighting;
  OSMesaContext context{};
  std::uint32_t
      window{};  // the pixel of the default framebuffer, which OSMesa wants and nobody sees
  GLuint program{};
  GLuint shadow_program{};
  GLuint framebuffer{};
  GLuint shadow_framebuffer{};
  GLuint shadow_maps{};                    // a layer for each light
  std::vector<Eigen::Matrix4d> shadow_W;   // of each light, from W to its clip space
  std::vector<Instance> shadow_instances;  // that the shadow maps show
  GLuint renderbuffers[3]{};
  std::vector<GlMesh> meshes;

  Gl(const geometry::CameraModel& camera_model, Lighting light)
      : model(camera_model), lighting(std::move(light)), context(CreateContext()) {}
  ~Gl() { OSMesaDestroyContext(context); }  // frees all that belongs to it
  Gl(const Gl&) = delete;
  Gl& operator=(const Gl&) = delete;

  GLint Uniform(const char* name) const { return glGetUniformLocation(program, name); }

  void Set(const char* name, const Eigen::Vector3f& value) const {
    glUniform3fv(Uniform(name), 1, value.data());
  }

  void MakeFramebuffer() {
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glGenRenderbuffers(3, renderbuffers);
    const std::pair<GLenum, GLenum> kinds[3] = {{GL_RGBA8, GL_COLOR_ATTACHMENT0},
                                                {GL_RGBA32F, GL_COLOR_ATTACHMENT1},
                                                {GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT}};
    for (int i = 0; i < 3; ++i) {
      glBindRenderbuffer(GL_RENDERBUFFER, renderbuffers[i]);
      glRenderbufferStorage(GL_RENDERBUFFER, kinds[i].first, model.width, model.height);
      glFramebufferRenderbuffer(GL_FRAMEBUFFER, kinds[i].second, GL_RENDERBUFFER, renderbuffers[i]);
    }
    constexpr GLenum kTargets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(2, kTargets);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      Throw<Error>("OpenGL has no {} x {} framebuffer", model.width, model.height);
    }
  }

  void MakeShadowMaps() {
    for (const Light& light : lighting.lights) {
      shadow_W.push_back(ShadowProjection(lighting, light));
    }
    glGenTextures(1, &shadow_maps);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D_ARRAY, shadow_maps);
    const auto layers = static_cast<GLsizei>(std::max<std::size_t>(shadow_W.size(), 1));
    glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, kShadowPixels, kShadowPixels,
                 layers, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glActiveTexture(GL_TEXTURE0);
    glGenFramebuffers(1, &shadow_framebuffer);
  }

  /// Draws the shadow maps anew when something has moved since the last time.
  void UpdateShadows(const std::vector<Instance>& instances) {
    if (!shadow_instances.empty() && SamePlaces(instances, shadow_instances)) return;
    shadow_instances = instances;
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer);
    glUseProgram(shadow_program);
    glViewport(0, 0, kShadowPixels, kShadowPixels);
    glEnable(GL_POLYGON_OFFSET_FILL);  // else a surface would shadow itself
    glPolygonOffset(kShadowSlopeBias, kShadowBias);
    const GLint clip_M = glGetUniformLocation(shadow_program, "clip_M");
    for (std::size_t i = 0; i < shadow_W.size(); ++i) {
      glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadow_maps, 0,
                                static_cast<GLint>(i));
      glDrawBuffer(GL_NONE);
      constexpr float kFarthest = 1.0F;
      glClearBufferfv(GL_DEPTH, 0, &kFarthest);
      for (const Instance& instance : instances) {
        const GlMesh& mesh = meshes.at(instance.mesh);
        const Eigen::Matrix4f matrix = (shadow_W[i] * instance.X_WM.matrix()).cast<float>();
        glUniformMatrix4fv(clip_M, 1, GL_FALSE, matrix.data());
        glBindVertexArray(mesh.vertex_array);
        glDrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
      }
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
  }

  void Clear() const {
    constexpr float kSky[4] = {kBackground[0], kBackground[1], kBackground[2], 0.0F};
    constexpr float kNothing[4] = {0.0F, 0.0F, 0.0F, 0.0F};
    constexpr float kFarthest = 1.0F;
    glClearBufferfv(GL_COLOR, 0, kSky);
    glClearBufferfv(GL_COLOR, 1, kNothing);
    glClearBufferfv(GL_DEPTH, 0, &kFarthest);
  }

  void SetLights(const Pose& X_CW) const {
    // From clip space, [-1, 1], to texture coordinates, [0, 1].
    const Eigen::Affine3d to_texture =
        Eigen::Translation3d(0.5, 0.5, 0.5) * Eigen::UniformScaling<double>(0.5);
    Set("up_C", X_CW.linear().col(2).cast<float>());
    glUniform1f(Uniform("ambient"), static_cast<float>(lighting.ambient));
    glUniform1i(Uniform("light_count"), static_cast<int>(lighting.lights.size()));
    for (std::size_t i = 0; i < lighting.lights.size(); ++i) {
      const Light& light = lighting.lights[i];
      Set(fmt::format("light_C[{}]", i).c_str(), (X_CW * light.position).cast<float>());
      Set(fmt::format("light_color[{}]", i).c_str(), (light.color * light.intensity).cast<float>());
      const Eigen::Matrix4f shadow_C =
          (to_texture.matrix() * shadow_W[i] * X_CW.inverse().matrix()).cast<float>();
      glUniformMatrix4fv(Uniform(fmt::format("shadow_C[{}]", i).c_str()), 1, GL_FALSE,
                         shadow_C.data());
    }
  }

  void DrawInstance(const Pose& X_CW, const Instance& instance) const {
    const GlMesh& mesh = meshes.at(instance.mesh);
    const Eigen::Matrix4f X_CM = (X_CW * instance.X_WM).matrix().cast<float>();
    glUniformMatrix4fv(Uniform("X_CM"), 1, GL_FALSE, X_CM.data());
    glUniform1f(Uniform("id"), static_cast<float>(instance.id));
    glBindVertexArray(mesh.vertex_array);
    for (const MaterialRange& range : mesh.ranges) {
      const GlMaterial& material = mesh.materials[range.material];
      Set("base_color", material.base_color);
      glUniform1f(Uniform("specular"), material.specular);
      glUniform1f(Uniform("shininess"), material.shininess);
      glUniform1i(Uniform("has_texture"), material.texture != 0 ? 1 : 0);
      glBindTexture(GL_TEXTURE_2D, material.texture);
      glDrawElements(GL_TRIANGLES, range.count, GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(sizeof(std::uint32_t) *
                                                   static_cast<std::size_t>(range.first)));
    }
  }

  Render ReadBack() const {
    cv::Mat rgba(model.height, model.width, CV_8UC4);
    cv::Mat surface(model.height, model.width, CV_32FC4);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, model.width, model.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data);
    glReadBuffer(GL_COLOR_ATTACHMENT1);
    glReadPixels(0, 0, model.width, model.height, GL_RGBA, GL_FLOAT, surface.data);
    Render render;
    render.color.create(rgba.size(), CV_8UC3);
    for (cv::Mat* mat :
         {&render.depth, &render.cos_incidence, &render.luminance, &render.specular}) {
      mat->create(rgba.size(), CV_32FC1);
    }
    render.id.create(rgba.size(), CV_16UC1);
    for (int v = 0; v < model.height; ++v) {
      const auto* c = rgba.ptr<cv::Vec4b>(v);
      const auto* s = surface.ptr<cv::Vec4f>(v);
      for (int u = 0; u < model.width; ++u) {
        const bool seen = s[u][3] > 0.0F;
        render.color.at<cv::Vec3b>(v, u) = {c[u][0], c[u][1], c[u][2]};
        render.depth.at<float>(v, u) = seen ? s[u][0] : std::numeric_limits<float>::quiet_NaN();
        render.cos_incidence.at<float>(v, u) = s[u][1];
        render.luminance.at<float>(v, u) = s[u][2];
        render.specular.at<float>(v, u) = static_cast<float>(c[u][3]) / 255.0F;
        render.id.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(s[u][3]);
      }
    }
    return render;
  }
};

namespace {

/// Makes a context current in this thread while it lives.
class Current {
 public:
  Current(OSMesaContext context, std::uint32_t* window) {
    if (OSMesaMakeCurrent(context, window, GL_UNSIGNED_BYTE, 1, 1) == GL_FALSE) {
      throw Error("OSMesa cannot make its context current");
    }
  }
  ~Current() { OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;
};

}  // namespace

Renderer::Renderer(const geometry::CameraModel& model, const Lighting& lighting) {
  model.Validate("renderer");
  if (lighting.lights.size() > Lighting::kMaxLights) {
    Throw<InvalidArgument>("{} lights; a scene may have {}", lighting.lights.size(),
                           Lighting::kMaxLights);
  }
  gl_ = std::make_unique<Gl>(model, lighting);
  const Current current(gl_->context, &gl_->window);
  gl_->program = Link(kVertexShader, kFragmentShader);
  gl_->shadow_program = Link(kShadowVertexShader, kShadowFragmentShader);
  gl_->MakeFramebuffer();
  gl_->MakeShadowMaps();
  glUseProgram(gl_->program);
  const Eigen::Matrix4f projection = Projection(model);
  glUniformMatrix4fv(gl_->Uniform("projection"), 1, GL_FALSE, projection.data());
  glUniform1i(gl_->Uniform("image"), 0);
  glUniform1i(gl_->Uniform("shadow_map"), 1);
  glEnable(GL_DEPTH_TEST);
}

Renderer::~Renderer() = default;

const geometry::CameraModel& Renderer::model() const { return gl_->model; }

int Renderer::AddMesh(const geometry::Mesh& mesh) {
  const Current current(gl_->context, &gl_->window);
  gl_->meshes.push_back(Upload(mesh));
  return static_cast<int>(gl_->meshes.size()) - 1;
}

Render Renderer::Draw(const Pose& X_WC, const std::vector<Instance>& instances) {
  const Current current(gl_->context, &gl_->window);
  gl_->UpdateShadows(instances);
  glBindFramebuffer(GL_FRAMEBUFFER, gl_->framebuffer);
  glUseProgram(gl_->program);
  glViewport(0, 0, gl_->model.width, gl_->model.height);
  const Pose X_CW = X_WC.inverse();
  gl_->Clear();
  gl_->SetLights(X_CW);
  for (const Instance& instance : instances) gl_->DrawInstance(X_CW, instance);
  return gl_->ReadBack();
}

}  // namespace secondlook::sim
