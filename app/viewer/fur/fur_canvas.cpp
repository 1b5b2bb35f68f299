#include "app/viewer/fur/fur_canvas.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "app/viewer/fur/fur_shaders.h"
#include "core/error.h"

namespace kappamu::app {

using render::FurCorners;

namespace {

/// Attributes of four floats each, and one of what remains.
std::vector<int> fours(int floats) {
  std::vector<int> sizes(static_cast<std::size_t>(floats) / 4, 4);
  if (floats % 4 != 0) sizes.push_back(floats % 4);
  return sizes;
}

void upload_to(GLuint buffer, const std::vector<float>& values) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  upload_floats(values, GL_DYNAMIC_DRAW);
}

GLint reflectance_of(const std::string& name) {
  return name == "even" ? 0 : name == "marschner" ? 2 : 1;
}

std::vector<float> norms_of(const render::Fur& fur) {
  using forward::shells::HairModel;
  const HairModel model =
      fur.reflectance == "marschner" ? HairModel::marschner : HairModel::kajiya_kay;
  const forward::shells::HairReflectance reflectance(model, fur.shine);
  std::vector<float> norms;
  for (const double n : reflectance.norms()) norms.push_back(static_cast<float>(n));
  return norms;
}

}  // namespace

FurCanvas::FurCanvas()
    : shell_(linked_program(shaders::fur_vertex, shaders::fur_fragment)),
      whole_(linked_program(shaders::fur_whole_vertex, shaders::fur_whole_fragment)) {
  glGenVertexArrays(1, &nothing_);
  glGenFramebuffers(1, &frame_);
  glGenTextures(1, &colour_);
  glGenRenderbuffers(1, &depth_);
}

void FurCanvas::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  glBindTexture(GL_TEXTURE_2D, colour_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour_, 0);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
}

void FurCanvas::upload(const FurModel::Shown& shown, Coat& coat) {
  if (coat.array == 0) {
    glGenVertexArrays(1, &coat.array);
    glGenBuffers(1, &coat.geometry);
    glGenBuffers(1, &coat.light);
    glGenTextures(3, coat.volumes.data());
    glBindVertexArray(coat.array);
    glBindBuffer(GL_ARRAY_BUFFER, coat.geometry);
    set_attributes(0, fours(FurCorners::geometry_floats));
    glBindBuffer(GL_ARRAY_BUFFER, coat.light);
    set_attributes((FurCorners::geometry_floats + 3) / 4, fours(FurCorners::light_floats));
  }
  if (std::exchange(coat.volume_version, shown.volume_version) != shown.volume_version) {
    for (std::size_t k = 0; k < 3; ++k) {
      glBindTexture(GL_TEXTURE_3D, coat.volumes[k]);
      glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA16F, shown.volume.width, shown.volume.width,
                   shown.volume.layers, 0, GL_RGBA, GL_FLOAT, shown.volume.texels[k].data());
      glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_S, GL_REPEAT);
      glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_T, GL_REPEAT);
      glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
      glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
      glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
      glGenerateMipmap(GL_TEXTURE_3D);
    }
  }
  if (std::exchange(coat.geometry_version, shown.geometry_version) != shown.geometry_version) {
    upload_to(coat.geometry, shown.corners.geometry);
    coat.corners = static_cast<int>(shown.corners.geometry.size()) / FurCorners::geometry_floats;
  }
  if (std::exchange(coat.light_version, shown.light_version) != shown.light_version) {
    upload_to(coat.light, shown.corners.light);
  }
}

void FurCanvas::draw_shells(const Seen& seen, const Viewport& at, const FurModel::Shown& shown,
                            Coat& coat) {
  const render::Fur& fur = shown.fur;
  const double distance = (seen.camera.target_mm - seen.camera.position_mm).norm();
  const double px_per_mm =
      at.height / (2.0 * distance * std::tan(0.5 * seen.camera.fov_deg * std::numbers::pi / 180.0));
  const forward::shells::ShellDetail detail =
      forward::shells::ShellDetail::of(shown.volume.layers, fur.length_mm * px_per_mm, apart_px);
  shells_ = detail.drawn();
  glUseProgram(shell_);
  const auto place = [&](const char* name) { return glGetUniformLocation(shell_, name); };
  const Eigen::Matrix4f matrix = clip_from_world(seen.camera, seen.near_mm, seen.far_mm,
                                                 static_cast<double>(at.width) / at.height);
  const Eigen::Vector3f eye = seen.camera.position_mm.cast<float>();
  const Eigen::Array3f root = fur.root_colour.cast<float>(), tip = fur.tip_colour.cast<float>();
  glUniformMatrix4fv(place("clip_from_world"), 1, GL_FALSE, matrix.data());
  glUniform3fv(place("eye"), 1, eye.data());
  glUniform3fv(place("root_colour"), 1, root.data());
  glUniform3fv(place("tip_colour"), 1, tip.data());
  glUniform3fv(place("lamp_colour"), 2, shown.corners.lamp_colour[0].data());
  glUniform1f(place("variation"), static_cast<float>(fur.variation));
  glUniform1f(place("shine"), static_cast<float>(fur.shine));
  glUniform1i(place("reflectance"), reflectance_of(fur.reflectance));
  if (std::exchange(coat.reflectance, fur.reflectance) != fur.reflectance) {
    coat.norms = norms_of(fur);
  }
  glUniform1fv(place("norm"), static_cast<GLsizei>(coat.norms.size()), coat.norms.data());
  glUniform1f(place("depth_of_shell"),
              static_cast<float>(shown.volume.r * shown.volume.layer_height * shown.volume.layers /
                                 detail.count));
  glUniform1f(place("level"), static_cast<float>(detail.level(shown.volume.layers)));
  glUniform1i(place("shells"), detail.count);
  glUniform1f(place("merged"), static_cast<float>(detail.merged));
  const std::array<const char*, 3> names{"hair", "tangents", "modes"};
  for (std::size_t k = 0; k < 3; ++k) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(k));
    glBindTexture(GL_TEXTURE_3D, coat.volumes[k]);
    glUniform1i(place(names[k]), static_cast<GLint>(k));
  }
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(coat.array);
  // What a ray leaves through lies behind what it enters by, outermost last.
  glEnable(GL_CULL_FACE);
  for (const bool behind : {true, false}) {
    glCullFace(behind ? GL_FRONT : GL_BACK);
    glUniform1i(place("outermost_first"), behind ? 1 : 0);
    glDrawArraysInstanced(GL_TRIANGLES, 0, coat.corners, detail.count);
  }
  glDisable(GL_CULL_FACE);
}

void FurCanvas::draw(Canvas& canvas, const Seen& seen, const Viewport& at, const FurModel& model) {
  coats_.resize(model.coats());
  for (std::size_t i = 0; i < coats_.size(); ++i) {
    if (model.shown(i).tile) upload(model.shown(i), coats_[i]);
  }
  GLint target = 0;  // of this canvas, or of another that it is drawn into
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  resize(at.width, at.height);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  glDisable(GL_BLEND);
  glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  Seen linear = seen;
  linear.linear = true;
  canvas.draw(linear, {0, 0, at.width, at.height});
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  for (std::size_t i = 0; i < coats_.size(); ++i) {
    if (coats_[i].corners > 0 && coats_[i].light_version > 0) {
      draw_shells(seen, at, model.shown(i), coats_[i]);
    }
  }
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
  glViewport(at.x, at.y, at.width, at.height);
  glUseProgram(whole_);
  glUniform1f(glGetUniformLocation(whole_, "exposure"),
              static_cast<float>(seen.exposure.value_or(1.0)));
  glUniform1i(glGetUniformLocation(whole_, "channel"), seen.channel);
  glUniform1i(glGetUniformLocation(whole_, "picture"), 0);
  glBindTexture(GL_TEXTURE_2D, colour_);
  glBindVertexArray(nothing_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace kappamu::app
