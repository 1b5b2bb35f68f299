#include "app/viewer/drawing/canvas.h"

#include <epoxy/gl.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>

#include "app/viewer/drawing/shaders.h"
#include "core/error.h"

namespace kappamu::app {

namespace {

using render::LitCorners;

constexpr GLint samples_per_pixel = 4;  ///< where the driver has as many

GLuint compiled(GLenum kind, const std::string& defined, const char* source) {
  const GLuint shader = glCreateShader(kind);
  const std::array<const char*, 5> texts{shaders::version, defined.c_str(),
                                         kind == GL_VERTEX_SHADER ? "" : shaders::tone,
                                         kind == GL_VERTEX_SHADER ? "" : shaders::sky, source};
  glShaderSource(shader, static_cast<GLsizei>(texts.size()), texts.data(), nullptr);
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

}  // namespace

unsigned linked_program(const char* vertex, const char* fragment, const std::string& defined) {
  const GLuint program = glCreateProgram();
  for (const GLuint shader : {compiled(GL_VERTEX_SHADER, defined, vertex),
                              compiled(GL_FRAGMENT_SHADER, defined, fragment)}) {
    glAttachShader(program, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program);
  GLint good = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &good);
  if (good != GL_TRUE) throw InputError("OpenGL does not link the shaders");
  return program;
}

void set_attributes(unsigned first, const std::vector<int>& sizes) {
  int stride = 0;
  for (const int size : sizes) stride += size;
  std::size_t offset = 0;
  for (const int size : sizes) {
    glEnableVertexAttribArray(first);
    glVertexAttribPointer(first, size, GL_FLOAT, GL_FALSE,
                          static_cast<GLsizei>(sizeof(float)) * stride,
                          reinterpret_cast<const void*>(sizeof(float) * offset));
    offset += static_cast<std::size_t>(size);
    ++first;
  }
}

void upload_floats(const std::vector<float>& values, unsigned usage) {
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
               values.data(), usage);
}

namespace {

void filter(GLint as) {
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                  as == GL_LINEAR ? GL_LINEAR_MIPMAP_LINEAR : as);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, as);
}

}  // namespace

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

Canvas::Canvas(const LitCorners::Geometry& geometry)
    : whole_(linked_program(shaders::whole_vertex, shaders::whole_fragment)) {
  glGenVertexArrays(1, &nothing_);
  glGenVertexArrays(1, &array_);
  for (unsigned* buffer : {&geometry_, &triangles_, &light_}) glGenBuffers(1, buffer);
  set_geometry(geometry);
  set_sources({});
  upload_floats(std::vector<float>(geometry.corners.size() / LitCorners::geometry_floats *
                                   LitCorners::light_floats(0)),
                GL_STREAM_DRAW);
  for (unsigned* texture : {&objects_, &sky_, &traced_}) {
    glGenTextures(1, texture);
    glBindTexture(GL_TEXTURE_2D, *texture);
    filter(GL_NEAREST);
    const std::array<float, 4> black{};
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 1, 1, 0, GL_RGBA, GL_FLOAT, black.data());
  }
}

Canvas::~Canvas() {
  glDeleteProgram(whole_);
  for (const auto& [parts, program] : surfaces_drawn_) glDeleteProgram(program);
  for (const unsigned* array : {&array_, &nothing_}) glDeleteVertexArrays(1, array);
  for (const unsigned* buffer : {&geometry_, &triangles_, &light_}) glDeleteBuffers(1, buffer);
  for (const unsigned* texture : {&objects_, &sky_, &traced_}) glDeleteTextures(1, texture);
  for (const unsigned* frame : {&frame_, &fine_frame_, &over_frame_}) {
    glDeleteFramebuffers(1, frame);
  }
  for (const unsigned* buffer : {&colour_, &depth_, &fine_colour_, &fine_depth_, &over_colour_}) {
    glDeleteRenderbuffers(1, buffer);
  }
}

void Canvas::set_geometry(const LitCorners::Geometry& geometry) {
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, geometry_);
  upload_floats(geometry.corners, GL_STREAM_DRAW);
  set_attributes(0, {3, 3, 1});
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(geometry.triangles.size() * sizeof geometry.triangles[0]),
               geometry.triangles.data(), GL_STREAM_DRAW);
  corners_ = 3 * static_cast<int>(geometry.triangles.size());
}

/// Leaves the buffer of light bound.
void Canvas::set_sources(const std::vector<Eigen::Vector4d>& sources) {
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, light_);
  set_attributes(3, std::vector<int>(3 + sources.size(), 3));
  for (std::size_t s = sources.size(); s < render::most_drawn_sources; ++s) {
    glDisableVertexAttribArray(static_cast<GLuint>(6 + s));
  }
  sources_.clear();
  for (const Eigen::Vector4d& source : sources) sources_.push_back(source.cast<float>());
}

void Canvas::set_light(const LitCorners& corners, const render::LiveAnswer& answer) {
  set_sources(answer.sources);
  upload_floats(corners.light(answer), GL_STREAM_DRAW);
  std::vector<float> surfaces;
  for (const render::SurfaceLight& surface : answer.surface) {
    surfaces.push_back(static_cast<float>(surface.boundary.eta));
    surfaces.push_back(static_cast<float>(surface.roughness));
  }
  if (surfaces == surfaces_) return;
  surfaces_ = std::move(surfaces);
  glBindTexture(GL_TEXTURE_2D, objects_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, render::table_cosines + 1,
               static_cast<GLsizei>(answer.surface.size()), 0, GL_RGBA, GL_FLOAT,
               render::object_table(answer.surface).data());
}

void Canvas::set_sky(const std::optional<render::Environment>& sky) {
  has_sky_ = sky.has_value();
  sky_visible_ = sky && sky->visible();
  if (!sky) return;
  sky_turn_ = static_cast<float>(sky->turn());
  const Image<float>& image = sky->image();
  glBindTexture(GL_TEXTURE_2D, sky_);
  filter(GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, image.width(), image.height(), 0, GL_RGB, GL_FLOAT,
               image.values().data());
  glGenerateMipmap(GL_TEXTURE_2D);
}

void Canvas::turn_sky(double degrees) {
  sky_turn_ = static_cast<float>(degrees * std::numbers::pi / 180.0);
}

void Canvas::set_traced(const Image<float>& radiance) {
  glBindTexture(GL_TEXTURE_2D, traced_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, radiance.width(), radiance.height(), 0, GL_RGB,
               GL_FLOAT, radiance.values().data());
}

void Canvas::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  if (frame_ == 0) {
    for (unsigned* frame : {&frame_, &fine_frame_, &over_frame_}) glGenFramebuffers(1, frame);
    for (unsigned* buffer : {&colour_, &depth_, &fine_colour_, &fine_depth_, &over_colour_}) {
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
  glBindRenderbuffer(GL_RENDERBUFFER, depth_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  glBindFramebuffer(GL_FRAMEBUFFER, over_frame_);
  glBindRenderbuffer(GL_RENDERBUFFER, over_colour_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, over_colour_);
  glBindFramebuffer(GL_FRAMEBUFFER, fine_frame_);
  glBindRenderbuffer(GL_RENDERBUFFER, fine_colour_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, fine_colour_);
  glBindRenderbuffer(GL_RENDERBUFFER, fine_depth_);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, fine_depth_);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  throw InputError("the display's driver has no picture of " + std::to_string(width) + " x " +
                   std::to_string(height) + " px; take a smaller width");
}

void Canvas::begin(int width, int height, Edges edges) {
  resize(width, height);
  edges_ = edges;
  glBindFramebuffer(GL_FRAMEBUFFER, edges == Edges::smooth ? fine_frame_ : frame_);
  glViewport(0, 0, width, height);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

/// For the lights as they are: a software renderer computes what a shader would only pass over.
unsigned Canvas::surface_program(bool lit) {
  const std::pair parts{lit ? static_cast<int>(sources_.size()) : -1, lit && has_sky_};
  unsigned& program = surfaces_drawn_[parts];
  if (program == 0) {
    program = linked_program(shaders::surface_vertex, shaders::surface_fragment,
                             "#define LIT " + std::to_string(lit ? 1 : 0) + "\n#define SOURCES " +
                                 std::to_string(std::max(0, parts.first)) + "\n#define SKY " +
                                 std::to_string(parts.second ? 1 : 0) + "\n");
  }
  return program;
}

/// What both programs take.
void Canvas::use(unsigned program, const Seen& seen) const {
  glUseProgram(program);
  const auto place = [&](const char* name) { return glGetUniformLocation(program, name); };
  glUniform1f(place("exposure"), static_cast<float>(seen.exposure.value_or(1.0)));
  glUniform1i(place("channel"), seen.channel);
  glUniform1i(place("linear_light"), seen.linear ? 1 : 0);
  glUniform1i(place("has_sky"), has_sky_ ? 1 : 0);
  glUniform1f(place("sky_turn"), sky_turn_);
  glUniform1i(place("sky_image"), 0);
  glUniform1i(place("objects"), 1);
  glUniform1i(place("picture"), 1);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, sky_);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, program == whole_ ? traced_ : objects_);
  glActiveTexture(GL_TEXTURE0);
}

void Canvas::draw(const Seen& seen, const Viewport& at) {
  glViewport(at.x, at.y, at.width, at.height);
  const Eigen::Matrix4f matrix = clip_from_world(seen.camera, seen.near_mm, seen.far_mm,
                                                 static_cast<double>(at.width) / at.height);
  glDisable(GL_DEPTH_TEST);
  if (seen.exposure && (seen.traced || sky_visible_)) {
    use(whole_, seen);
    const Eigen::Matrix4f inverse = matrix.inverse();
    glUniformMatrix4fv(glGetUniformLocation(whole_, "world_from_clip"), 1, GL_FALSE,
                       inverse.data());
    glUniform1i(glGetUniformLocation(whole_, "traced"), seen.traced ? 1 : 0);
    glBindVertexArray(nothing_);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  if (seen.traced) return;
  glEnable(GL_DEPTH_TEST);
  const unsigned program = surface_program(seen.exposure.has_value());
  use(program, seen);
  const auto place = [&](const char* name) { return glGetUniformLocation(program, name); };
  const Eigen::Vector3f eye = seen.camera.position_mm.cast<float>();
  glUniformMatrix4fv(place("clip_from_world"), 1, GL_FALSE, matrix.data());
  glUniform3fv(place("eye"), 1, eye.data());
  if (!sources_.empty()) {
    glUniform4fv(place("source"), static_cast<GLsizei>(sources_.size()), sources_[0].data());
  }
  glBindVertexArray(array_);
  // Bodies are closed. Their far side would show through along contours, dark and in single pixels.
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glDrawElements(GL_TRIANGLES, corners_, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_CULL_FACE);
}

void Canvas::copy(unsigned from, unsigned to) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void Canvas::end() {
  if (edges_ == Edges::smooth) copy(fine_frame_, frame_);
}

void Canvas::draw_over() {
  copy(frame_, over_frame_);
  glBindFramebuffer(GL_FRAMEBUFFER, over_frame_);
  glViewport(0, 0, width_, height_);
}

void Canvas::show(int window_width, int window_height) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, over_frame_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, window_width, window_height, GL_COLOR_BUFFER_BIT,
                    GL_NEAREST);
}

void Canvas::finish() const {
  glFinish();
}

Image<std::uint8_t> Canvas::picture() const {
  Image<std::uint8_t> flipped(width_, height_, 3), image(width_, height_, 3);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, over_frame_);
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
