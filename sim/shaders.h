#pragma once

namespace secondlook::sim {

// The OpenGL programs of sim/renderer.cc. Everything is computed in the camera frame C, where the
// eye is the origin.

inline constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec3 color;
uniform mat4 X_CM;
uniform mat4 projection;
out vec3 p_C;
out vec3 normal_C;
out vec2 texture_uv;
out vec3 vertex_color;
void main() {
  p_C = (X_CM * vec4(position, 1.0)).xyz;
  normal_C = mat3(X_CM) * normal;
  texture_uv = uv;
  vertex_color = color;
  gl_Position = projection * vec4(p_C, 1.0);
}
)";

// Diffuse light of all lamps and of the surroundings, Blinn-Phong highlights, sRGB encoding.
inline constexpr const char* kFragmentShader = R"(#version 330 core
in vec3 p_C;
in vec3 normal_C;
in vec2 texture_uv;
in vec3 vertex_color;
uniform vec3 base_color;
uniform bool has_texture;
uniform sampler2D image;
uniform float specular;
uniform float shininess;
uniform float id;
uniform vec3 up_C;
uniform float ambient;
uniform int light_count;
uniform vec3 light_C[8];
uniform vec3 light_color[8];
uniform mat4 shadow_C[8];  // from C to the texture coordinates of the light's shadow map
uniform sampler2DArrayShadow shadow_map;
layout(location = 0) out vec4 color_out;    // sRGB, specular
layout(location = 1) out vec4 surface_out;  // z, cosine of incidence, luminance, id

// The share of lamp i that reaches p_C.
float Lit(int i) {
  vec4 q = shadow_C[i] * vec4(p_C, 1.0);
  if (q.w <= 0.0) return 1.0;
  vec3 s = q.xyz / q.w;
  if (any(lessThan(s, vec3(0.0))) || any(greaterThan(s, vec3(1.0)))) return 1.0;
  return texture(shadow_map, vec4(s.xy, float(i), s.z));
}

void main() {
  vec3 albedo = base_color * vertex_color;
  if (has_texture) albedo *= texture(image, texture_uv, -0.5).rgb;
  vec3 to_eye = normalize(-p_C);
  vec3 n = normalize(normal_C);
  if (dot(n, to_eye) < 0.0) n = -n;
  vec3 light = vec3(ambient * (0.85 + 0.15 * dot(n, up_C)));
  vec3 highlight = vec3(0.0);
  for (int i = 0; i < light_count; ++i) {
    vec3 to_light = normalize(light_C[i] - p_C);
    float facing = dot(n, to_light);
    if (facing <= 0.0) continue;
    vec3 arriving = Lit(i) * light_color[i];
    light += facing * arriving;
    if (shininess > 0.0) {
      float glance = max(dot(n, normalize(to_light + to_eye)), 0.0);
      highlight += specular * pow(glance, shininess) * arriving;
    }
  }
  vec3 linear = clamp(albedo * light + highlight, 0.0, 1.0);
  vec3 srgb = mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear,
                  vec3(lessThan(linear, vec3(0.0031308))));
  color_out = vec4(srgb, specular);
  surface_out = vec4(p_C.z, dot(n, to_eye), dot(albedo, vec3(0.2126, 0.7152, 0.0722)), id);
}
)";

// What a lamp sees, for its shadow map: depth alone.
inline constexpr const char* kShadowVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 clip_M;
void main() { gl_Position = clip_M * vec4(position, 1.0); }
)";

inline constexpr const char* kShadowFragmentShader = R"(#version 330 core
void main() {}
)";

}  // namespace secondlook::sim
