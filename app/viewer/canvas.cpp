#include "app/viewer/canvas.h"

#include <epoxy/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include "core/error.h"

namespace kappamu::app {

namespace {

using render::LitCorners;

constexpr GLint samples_per_pixel = 4;  ///< where the driver has as many

constexpr const char* vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 boundary;
layout(location = 3) in vec3 outflow;
layout(location = 4) in vec3 entering;
uniform mat4 clip_from_world;
out vec3 at, facing, eta_a_rphi, out_flow, in_flow;
void main() {
  at = position; facing = normal; eta_a_rphi = boundary; out_flow = outflow; in_flow = entering;
  gl_Position = clip_from_world * vec4(position, 1.0);
}
)";

// Radiance as render/picture/shading.h, tone curve as render::tone_mapped().
constexpr const char* fragment_shader = R"(#version 330 core
in vec3 at, facing, eta_a_rphi, out_flow, in_flow;
uniform vec3 eye;
uniform float exposure;
uniform int channel;
uniform bool lit;
out vec4 colour;
const float pi = 3.14159265358979;
void main() {
  float eta = eta_a_rphi.x;
  float c = clamp(dot(normalize(facing), normalize(eye - at)), 1e-3, 1.0);
  float inside = sqrt(1.0 - (1.0 - c * c) / (eta * eta));
  float s = (c - eta * inside) / (c + eta * inside), p = (eta * c - inside) / (eta * c + inside);
  float through = (1.0 - 0.5 * (s * s + p * p)) / (eta * eta);
  vec3 radiance = through * ((2.0 * eta_a_rphi.y + 3.0 * inside) / (4.0 * pi) * out_flow +
                             in_flow / (pi * (1.0 - eta_a_rphi.z)));
  vec3 linear = lit ? max(exposure * radiance, 0.0) : vec3(0.05 + 0.25 * c);
  if (channel > 0) linear = vec3(linear[channel - 1]);
  float brightest = max(linear.r, max(linear.g, linear.b));
  const float shoulder = 0.6, room = 0.4;
  if (brightest > shoulder) {
    linear *= (shoulder + room * (1.0 - exp(-(brightest - shoulder) / room))) / brightest;
  }
  vec3 low = 12.92 * linear, high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  colour = vec4(mix(high, low, lessThanEqual(linear, vec3(0.0031308))), 1.0);
}
)";

GLuint compiled(GLenum kind, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good != GL_TRUE) {
    char log[1024] = "";
    glGetShaderInfoLog(shader, sizeof(log), nullptr, log);
    throw InputError(std::string("OpenGL refuses a shader: ") + log);
  }
  return shader;
}

GLuint linked() {
  const GLuint program = glCreateProgram();
  for (const GLuint shader :
       {compiled(GL_VERTEX_SHADER, vertex_shader), compiled(GL_FRAGMENT_SHADER, fragment_shader)}) {
    glAttachShader(program, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program);
  GLint good = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &good);
  if (good != GL_TRUE) throw InputError("OpenGL does not link the shaders");
  return program;
}

/// Attributes of three floats each, interleaved, from `first` on.
void attributes(GLuint first, int floats) {
  for (int i = 0; 3 * i < floats; ++i) {
    const GLuint at = first + static_cast<GLuint>(i);
    glEnableVertexAttribArray(at);
    const auto offset = sizeof(float) * static_cast<std::size_t>(3 * i);
    glVertexAttribPointer(at, 3, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(sizeof(float)) * floats,
                          reinterpret_cast<const void*>(offset));
  }
}

void upload(const std::vector<float>& values, GLenum usage) {
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
               values.data(), usage);
}

Eigen::Matrix4f clip_from_world(const render::Camera& camera, double near_mm, double far_mm,
                                double aspect) {
  const Eigen::Vector3d forward = (camera.target_mm - camera.position_mm).normalized();
  const Eigen::Vector3d right = forward.cross(camera.up).normalized();
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.block<1, 3>(0, 0) = right.transpose();
  view.block<1, 3>(1, 0) = right.cross(forward).transpose();
  view.block<1, 3>(2, 0) = -forward.transpose();
  view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.position_mm;
  const double focal = 1.0 / std::tan(0.5 * camera.fov_deg * std::numbers::pi / 180.0);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = focal / aspect;
  clip(1, 1) = focal;
  clip(2, 2) = (far_mm + near_mm) / (near_mm - far_mm);
  clip(2, 3) = 2.0 * far_mm * near_mm / (near_mm - far_mm);
  clip(3, 2) = -1.0;
  return (clip * view).cast<float>();
}

}  // namespace

Canvas::Canvas(const std::vector<float>& geometry)
    : program_(linked()),
      corners_(static_cast<int>(geometry.size()) / LitCorners::geometry_floats) {
  glGenVertexArrays(1, &array_);
  glBindVertexArray(array_);
  glGenBuffers(1, &geometry_);
  glBindBuffer(GL_ARRAY_BUFFER, geometry_);
  upload(geometry, GL_STATIC_DRAW);
  attributes(0, LitCorners::geometry_floats);
  glGenBuffers(1, &light_);
  set_light(std::vector<float>(static_cast<std::size_t>(corners_) * LitCorners::light_floats));
  attributes(LitCorners::geometry_floats / 3, LitCorners::light_floats);
}

void Canvas::set_geometry(const std::vector<float>& geometry) {
  glBindBuffer(GL_ARRAY_BUFFER, geometry_);
  upload(geometry, GL_STREAM_DRAW);
}

void Canvas::set_light(const std::vector<float>& light) {
  glBindBuffer(GL_ARRAY_BUFFER, light_);
  upload(light, GL_STREAM_DRAW);
}

void Canvas::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  if (frame_ == 0) {
    for (unsigned* frame : {&frame_, &fine_frame_}) glGenFramebuffers(1, frame);
    for (unsigned* buffer : {&colour_, &fine_colour_, &fine_depth_}) {
      glGenRenderbuffers(1, buffer);
    }
  }
  GLint samples = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &samples);
  samples = std::min(samples, samples_per_pixel);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  glBindRenderbuffer(GL_RENDERBUFFER, colour_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  glBindFramebuffer(GL_FRAMEBUFFER, fine_frame_);
  glBindRenderbuffer(GL_RENDERBUFFER, fine_colour_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, fine_colour_);
  glBindRenderbuffer(GL_RENDERBUFFER, fine_depth_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, fine_depth_);
}

void Canvas::draw(const render::Camera& camera, std::optional<double> exposure, int channel,
                  double near_mm, double far_mm, int width, int height, const Viewport& at) {
  resize(width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, fine_frame_);
  glViewport(0, 0, width, height);
  glEnable(GL_DEPTH_TEST);
  glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glViewport(at.x, at.y, at.width, at.height);
  glUseProgram(program_);
  const Eigen::Matrix4f matrix =
      clip_from_world(camera, near_mm, far_mm, static_cast<double>(at.width) / at.height);
  const Eigen::Vector3f eye = camera.position_mm.cast<float>();
  glUniformMatrix4fv(glGetUniformLocation(program_, "clip_from_world"), 1, GL_FALSE, matrix.data());
  glUniform3fv(glGetUniformLocation(program_, "eye"), 1, eye.data());
  glUniform1f(glGetUniformLocation(program_, "exposure"),
              static_cast<float>(exposure.value_or(1.0)));
  glUniform1i(glGetUniformLocation(program_, "lit"), exposure ? 1 : 0);
  glUniform1i(glGetUniformLocation(program_, "channel"), channel);
  glBindVertexArray(array_);
  glDrawArrays(GL_TRIANGLES, 0, corners_);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, fine_frame_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, frame_);
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
}

void Canvas::show(int window_width, int window_height) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, frame_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, window_width, window_height, GL_COLOR_BUFFER_BIT,
                    GL_NEAREST);
}

Image<std::uint8_t> Canvas::picture() const {
  Image<std::uint8_t> flipped(width_, height_, 3), image(width_, height_, 3);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, frame_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, flipped.values().data());
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = flipped(x, height_ - 1 - y, c);
    }
  }
  return image;
}

}  // namespace kappamu::app
