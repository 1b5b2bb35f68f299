// Shells of fur on the graphics card: forward/shells/lit_hair.h at a fragment, with the light and
// the places of render/fur/live_fur.h.
#pragma once

namespace kappamu::app::shaders {

/// FurCorners' floats as they lie: geometry in g0 ... g6, light in l0 ... l8.
inline constexpr const char* fur_vertex = R"(
layout(location = 0) in vec4 a0;
layout(location = 1) in vec4 a1;
layout(location = 2) in vec4 a2;
layout(location = 3) in vec4 a3;
layout(location = 4) in vec4 a4;
layout(location = 5) in vec4 a5;
layout(location = 6) in vec2 a6;
layout(location = 7) in vec4 b0;
layout(location = 8) in vec4 b1;
layout(location = 9) in vec4 b2;
layout(location = 10) in vec4 b3;
layout(location = 11) in vec4 b4;
layout(location = 12) in vec4 b5;
layout(location = 13) in vec4 b6;
layout(location = 14) in vec4 b7;
layout(location = 15) in float b8;
uniform mat4 clip_from_world;
uniform int shells;
uniform float merged;
uniform bool outermost_first;
out vec4 g0, g1, g2, g3, g4, g5, l0, l1, l2, l3, l4, l5, l6, l7;
out vec2 g6;
out float l8;
flat out float shell_weight;
void main() {
  int shell = outermost_first ? shells - 1 - gl_InstanceID : gl_InstanceID;
  float sense = shell % 2 == 0 ? 1.0 : -1.0;
  float height = (float(shell) + 0.5 + 0.5 * sense * merged) / float(shells);
  shell_weight = 1.0 + sense * merged;
  vec3 position = a0.xyz + height * a5.y * vec3(a0.w, a1.xy);
  g0 = vec4(position, a0.w); g1 = a1; g2 = a2; g3 = a3; g4 = a4;
  g5 = vec4(a5.x, height, a5.zw);
  g6 = a6;
  l0 = b0; l1 = b1; l2 = b2; l3 = b3; l4 = b4; l5 = b5; l6 = b6; l7 = b7; l8 = b8;
  gl_Position = clip_from_world * vec4(position, 1.0);
}
)";

inline constexpr const char* fur_fragment = R"(
in vec4 g0, g1, g2, g3, g4, g5, l0, l1, l2, l3, l4, l5, l6, l7;
in vec2 g6;
in float l8;
flat in float shell_weight;
uniform vec3 eye, root_colour, tip_colour;
uniform vec3 lamp_colour[2];
uniform float variation, shine, depth_of_shell, level;
uniform int reflectance;  // 0 even, 1 Kajiya and Kay, 2 Marschner
uniform float norm[65];
uniform sampler3D hair, tangents, modes;
out vec4 colour;
const float pi = 3.14159265358979;
float gaussian(float x, float width) {
  return exp(-0.5 * x * x / (width * width)) / (width * sqrt(2.0 * pi));
}
// forward/shells/reflectance.h, before shine.
vec3 lobes(float l, float v, float azimuth, vec3 own) {
  if (reflectance == 1) {
    float along = sqrt(1.0 - l * l) * sqrt(1.0 - v * v) - l * v;
    return vec3(pow(max(along, 0.0), 20.0));
  }
  float half_angle = 0.5 * (asin(l) + asin(v)), difference = 0.5 * (asin(v) - asin(l));
  float shift = (v < 0.0 ? 5.0 : -5.0) * pi / 180.0, rough = 8.0 * pi / 180.0;
  float c = max(0.05, cos(difference)), half_azimuth = abs(cos(0.5 * azimuth));
  float turn = cos(azimuth), f0 = pow(0.55 / 2.55, 2.0);
  float f = f0 + (1.0 - f0) * pow(1.0 - clamp(c * half_azimuth, 0.0, 1.0), 5.0);
  float through = (1.0 - f) * (1.0 - f);
  float r = gaussian(half_angle - shift, rough) * 0.25 * half_azimuth * f;
  float tt = gaussian(half_angle + 0.5 * shift, 0.5 * rough) * through * exp(-3.65 * turn - 3.98);
  float trt = gaussian(half_angle + 1.5 * shift, 2.0 * rough) * through * f *
              exp(17.0 * turn - 16.78);
  return (r + tt * own + trt * own * own) / (c * c);
}
vec3 reflected(vec3 t, vec3 light, vec3 view, vec3 own) {
  if (reflectance == 0) return own / (4.0 * pi);
  float l = clamp(dot(t, light), -1.0, 1.0), v = clamp(dot(t, view), -1.0, 1.0);
  vec3 a = light - l * t, b = view - v * t;
  float lengths = length(a) * length(b);
  float azimuth = lengths > 1e-6 ? acos(clamp(dot(a, b) / lengths, -1.0, 1.0)) : 0.5 * pi;
  float place = min(abs(v), 1.0) * 64.0;
  int low = min(int(place), 63);
  float n = mix(norm[low], norm[low + 1], place - float(low));
  return (1.0 - shine) * sqrt(1.0 - l * l) / (pi * pi) * own + shine * lobes(l, v, azimuth, own) / n;
}
void main() {
  // Tile coordinates and weights of four patches.
  vec3 patches[4] = vec3[4](g2.yzw, g3.xyz, vec3(g3.w, g4.xy), vec3(g4.zw, g5.x));
  float most = 0.0, all = 0.0, w[4];
  for (int k = 0; k < 4; ++k) {
    float sharp = patches[k].z * patches[k].z;
    w[k] = sharp * sharp;
    most = max(most, w[k]);
  }
  vec4 of_hair = vec4(0.0), of_tangent = vec4(0.0), of_modes = vec4(0.0);
  for (int k = 0; k < 4; ++k) {
    if (w[k] <= 0.0 || w[k] < 0.02 * most) continue;
    vec3 at = vec3(patches[k].xy, g5.y);
    vec4 here = textureLod(hair, at, level);
    all += w[k];
    if (here.x <= 0.0) continue;
    of_hair += w[k] * here;
    of_tangent += w[k] * textureLod(tangents, at, level);
    of_modes += w[k] * textureLod(modes, at, level);
  }
  float density = of_hair.x / max(all, 1e-20) * g5.z;
  if (density < 1e-4) discard;
  float per = 1.0 / of_hair.x;
  vec3 own = mix(root_colour, tip_colour, of_hair.y * per) * vec3(g5.w, g6);
  own = min(own * (1.0 + variation * (2.0 * of_hair.z * per - 1.0)), 1.0);
  float m0 = of_hair.w * per, m1 = of_tangent.w * per, m2 = of_modes.x * per,
        m3 = of_modes.y * per, m4 = of_modes.z * per;
  vec3 normal = normalize(vec3(g0.w, g1.xy)), view = normalize(eye - g0.xyz);
  vec3 comb = vec3(g1.zw, g2.x);
  comb = normalize(comb - dot(comb, normal) * normal);
  vec3 seen = vec3(dot(view, comb), dot(view, cross(normal, comb)), dot(view, normal));
  vec3 t = of_tangent.xyz;
  t = dot(t, t) > 0.0 ? normalize(t) : vec3(0.0, 0.0, 1.0);
  vec3 sky = m0 * l0.xyz + m1 * vec3(l0.w, l1.xy) + m2 * vec3(l1.zw, l2.x) + m3 * l2.yzw +
             m4 * l3.xyz;
  vec3 radiance = own * max(sky, 0.0) / (4.0 * pi);
  float first = m0 * l3.w + m1 * l4.x + m2 * l4.y + m3 * l4.z + m4 * l4.w;
  float second = m0 * l6.x + m1 * l6.y + m2 * l6.z + m3 * l6.w + m4 * l7.x;
  if (l5.w > 0.0) {
    radiance += clamp(first, 0.0, 1.0) * l5.w * lamp_colour[0] *
                reflected(t, normalize(l5.xyz), seen, own);
  }
  if (l8 > 0.0) {
    radiance += clamp(second, 0.0, 1.0) * l8 * lamp_colour[1] *
                reflected(t, normalize(l7.yzw), seen, own);
  }
  float opaque = 1.0 - exp(-shell_weight * depth_of_shell * density / max(abs(seen.z), 0.15));
  colour = opaque * vec4(radiance, 1.0);
}
)";

inline constexpr const char* fur_whole_vertex = R"(
out vec2 on_picture;
void main() {
  vec2 corner = vec2(float(gl_VertexID % 2), float(gl_VertexID / 2));
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
  on_picture = 2.0 * corner;
}
)";

/// The linear picture, with the background where it is free.
inline constexpr const char* fur_whole_fragment = R"(
in vec2 on_picture;
uniform sampler2D picture;
out vec4 colour;
void main() {
  vec4 seen = texture(picture, on_picture);
  if (seen.a < 1e-3) discard;
  colour = shown(seen.rgb);
}
)";

}  // namespace kappamu::app::shaders
