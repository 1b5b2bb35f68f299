// What readers of mesh files put together: vertices, polygons cut into triangles, parts.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "io/mesh_file.h"

namespace kappamu::io {

class MeshBuilder {
 public:
  /// `name` begins every sentence; `face_word` is what numbers of faces are called.
  MeshBuilder(std::string name, std::string face_word) : name_(std::move(name)) {
    result_.face_word = std::move(face_word);
  }

  /// Throws InputError: "<file>: <what>".
  [[noreturn]] void fail(const std::string& what) const;
  /// What the file calls something, quoted and short enough for a sentence.
  static std::string quoted(std::string_view word);

  std::size_t vertices() const { return result_.mesh.vertices.size(); }
  void add_vertex(const Eigen::Vector3d& position);
  /// Faces that follow belong to it.
  void begin_part(const std::string& kind, std::string_view name);
  /// Corners are numbers of vertices that are there; those of fewer than three bound nothing.
  /// `face` is its line or number; `texture` has one pair per corner, or none.
  void add_polygon(std::span<const int> corners, std::size_t face,
                   std::span<const Eigen::Vector2f> texture = {});
  void require_corners(std::size_t corners, std::size_t face) const;
  /// Things of a kind that are no surface, such as "lines": stated in the end.
  void leave_out(const std::string& kind, std::size_t count = 1);
  void note(const std::string& sentence) { result_.notes.push_back(name_ + ": " + sentence); }
  /// Positions are rounded to `step` by the file's kind of number.
  void rounded_to(double step) { step_ = std::max(step_, step); }

  FileMesh take();

 private:
  std::string left_out() const;
  void require_whole_texture();

  std::string name_;
  FileMesh result_;
  std::vector<std::pair<std::string, std::size_t>> left_out_;
  double step_ = 0.0;
};

/// Rounding of the largest coordinate as a 32-bit float.
double float_step(const Eigen::Vector3d& position);

}  // namespace kappamu::io
