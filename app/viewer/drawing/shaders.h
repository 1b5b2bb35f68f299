// What the graphics card computes. Radiance is that of render/picture/shading.h with what
// render/live/lit_corners.h leaves out; reflection is that of render/picture/ggx.h.
#pragma once

namespace kappamu::app::shaders {

inline constexpr const char* version = "#version 330 core\n";

/// Linear radiance to sRGB: render::tone_mapped().
inline constexpr const char* tone = R"(
uniform float exposure;
uniform int channel;
uniform bool linear_light;
vec4 shown(vec3 radiance) {
  if (linear_light) return vec4(radiance, 1.0);
  vec3 linear = max(exposure * radiance, 0.0);
  if (channel > 0) linear = vec3(linear[channel - 1]);
  float brightest = max(linear.r, max(linear.g, linear.b));
  const float shoulder = 0.6, room = 0.4;
  if (brightest > shoulder) {
    linear *= (shoulder + room * (1.0 - exp(-(brightest - shoulder) / room))) / brightest;
  }
  vec3 low = 12.92 * linear, high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  return vec4(mix(high, low, lessThanEqual(linear, vec3(0.0031308))), 1.0);
}
)";

/// The environment: render/light/environment.h. `blur`: level of the image's halvings.
inline constexpr const char* sky = R"(
uniform sampler2D sky_image;
uniform float sky_turn;
uniform bool has_sky;
vec3 sky(vec3 direction, float blur) {
  if (!has_sky) return vec3(0.0);
  const float pi = 3.14159265358979;
  float u = (atan(direction.x, -direction.z) + sky_turn) / (2.0 * pi) + 0.5;
  float v = acos(clamp(direction.y, -1.0, 1.0)) / pi;
  return textureLod(sky_image, vec2(u, v), blur).rgb;
}
)";

inline constexpr const char* surface_vertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float object;
layout(location = 3) in vec3 outflow;
layout(location = 4) in vec3 entering;
layout(location = 5) in vec3 albedo;
#if SOURCES > 0
layout(location = 6) in vec3 arriving_of[SOURCES];
centroid out vec3 arriving[SOURCES];
#endif
uniform mat4 clip_from_world;
centroid out vec3 at, facing, out_flow, in_flow, once;
out vec3 place, turned;
flat out int which;
void main() {
  place = position; turned = normal;
  at = position; facing = normal; out_flow = outflow; in_flow = entering; once = albedo;
#if SOURCES > 0
  arriving = arriving_of;
#endif
  which = int(object + 0.5);
  gl_Position = clip_from_world * vec4(position, 1.0);
}
)";

inline constexpr const char* surface_fragment = R"(
centroid in vec3 at, facing, out_flow, in_flow, once;
in vec3 place, turned;  // at the pixel's centre, as derivatives need them
flat in int which;
uniform vec3 eye;
#if SOURCES > 0
centroid in vec3 arriving[SOURCES];
uniform vec4 source[SOURCES];
#endif
uniform sampler2D objects;
out vec4 colour;
const float pi = 3.14159265358979;
float inside_of(float c, float eta) { return sqrt(1.0 - (1.0 - c * c) / (eta * eta)); }
float reflectance_of(float c, float eta) {
  float d = inside_of(c, eta);
  float s = (c - eta * d) / (c + eta * d), p = (eta * c - d) / (eta * c + d);
  return 0.5 * (s * s + p * p);
}
float masking_of(float c, float alpha) {
  return 0.5 * (sqrt(1.0 + alpha * alpha * (1.0 / (c * c) - 1.0)) - 1.0);
}
void main() {
  vec4 surface = texelFetch(objects, ivec2(0, which), 0);
  float eta = surface.x, alpha = surface.w;
  vec3 normal = normalize(facing), view = normalize(eye - at);
  // As the picture's rays do: where the smooth normal turns away, the triangle's is used.
  if (dot(normal, view) < 0.02) {
    normal = normalize(cross(dFdx(place), dFdy(place)));
    if (dot(normal, view) < 0.0) normal = -normal;
  }
  // Along a contour a pixel holds cosines from 0 on: one of them alone would be dark in places.
  float within = 0.4 * fwidth(dot(normalize(turned), normalize(eye - place)));
  float c = clamp(max(dot(normal, view), min(within, 0.5)), 1e-3, 1.0);
#if LIT == 0
  colour = shown(vec3(0.05 + 0.25 * c) / exposure);
#else
  float inside = inside_of(c, eta);
  float through = (1.0 - reflectance_of(c, eta)) / (eta * eta);
  vec3 radiance = through * ((2.0 * surface.y + 3.0 * inside) / (4.0 * pi) * out_flow +
                             in_flow / (pi * (1.0 - surface.z)));
#if SOURCES > 0
  for (int i = 0; i < SOURCES; ++i) {
    vec3 light = normalize(source[i].xyz - source[i].w * at);
    float l = dot(normal, light);
    if (l <= 0.0) continue;
    float l_inside = inside_of(l, eta);
    float enters = (1.0 - reflectance_of(l, eta)) * l / l_inside;
    radiance += through * once * arriving[i] * enters * l_inside / (4.0 * pi * (l_inside + inside));
    if (alpha < 1e-3 || eta == 1.0) continue;
    vec3 facet = normalize(view + light);
    float cosine = max(dot(normal, facet), 0.0), a2 = alpha * alpha;
    float t = cosine * cosine * (a2 - 1.0) + 1.0;
    float masking = 1.0 / (1.0 + masking_of(c, alpha) + masking_of(l, alpha));
    radiance += arriving[i] * reflectance_of(min(1.0, dot(facet, light)), eta) * a2 /
                (pi * t * t) * masking / (4.0 * c);
  }
#endif
#if SKY == 1
  float row = c * float(textureSize(objects, 0).x - 2);
  int below = min(int(row), textureSize(objects, 0).x - 3);
  float reflected = mix(texelFetch(objects, ivec2(1 + below, which), 0).x,
                        texelFetch(objects, ivec2(2 + below, which), 0).x, row - float(below));
  float blur = log2(1.0 + 0.5 * alpha * float(textureSize(sky_image, 0).x));
  radiance += reflected * sky(reflect(-view, normal), blur);
#endif
  colour = shown(radiance);
#endif
}
)";

inline constexpr const char* whole_vertex = R"(
uniform mat4 world_from_clip;
out vec2 on_picture;
out vec3 nearby, far_away;
void main() {
  vec2 corner = vec2(float(gl_VertexID % 2), float(gl_VertexID / 2));
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
  on_picture = 2.0 * corner;
  vec4 first = world_from_clip * vec4(gl_Position.xy, -1.0, 1.0);
  vec4 last = world_from_clip * vec4(gl_Position.xy, 1.0, 1.0);
  nearby = first.xyz / first.w; far_away = last.xyz / last.w;
}
)";

/// The traced picture, or what is behind all objects.
inline constexpr const char* whole_fragment = R"(
in vec2 on_picture;
in vec3 nearby, far_away;
uniform bool traced;
uniform sampler2D picture;
out vec4 colour;
void main() {
  if (traced) {
    ivec2 size = textureSize(picture, 0);
    ivec2 pixel = ivec2(on_picture * vec2(size));
    colour = shown(texelFetch(picture, ivec2(pixel.x, size.y - 1 - pixel.y), 0).rgb);
  } else {
    colour = shown(sky(normalize(far_away - nearby), 0.0));
  }
}
)";

}  // namespace kappamu::app::shaders
