#include "io/mesh/mesh_builder.h"

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "core/file_name.h"
#include "core/mesh/polygon.h"
#include "core/shown_text.h"

namespace kappamu::io {

namespace {

const Eigen::Vector2f nowhere = Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
const CornerTexture no_texture{nowhere, nowhere, nowhere};

}  // namespace

void MeshBuilder::fail(const std::string& what) const {
  throw InputError(name_ + ": " + what);
}

std::string MeshBuilder::quoted(std::string_view word) {
  constexpr std::size_t longest = 40;
  return "'" + shown_name(word.substr(0, longest)) + "'";
}

void MeshBuilder::add_vertex(const Eigen::Vector3d& position) {
  if (vertices() == 3 * most_triangles) {
    fail("has more than " + std::to_string(3 * most_triangles) + " vertices; decimate the mesh");
  }
  result_.mesh.vertices.push_back(position);
}

void MeshBuilder::begin_part(const std::string& kind, std::string_view name) {
  const int first = static_cast<int>(result_.mesh.triangles.size());
  if (!result_.parts.empty() && result_.parts.back().first_triangle == first) {
    result_.parts.pop_back();
  }
  result_.parts.push_back({first, name.empty() ? kind : kind + " " + quoted(name)});
}

void MeshBuilder::require_corners(std::size_t corners, std::size_t face) const {
  if (corners <= most_polygon_corners) return;
  fail("the polygon of " + result_.face_word + " " + std::to_string(face) + " has " +
       std::to_string(corners) + " corners; at most " + std::to_string(most_polygon_corners) +
       " are taken, triangulate the mesh");
}

void MeshBuilder::add_polygon(std::span<const int> corners, std::size_t face,
                              std::span<const Eigen::Vector2f> texture) {
  require_corners(corners.size(), face);
  if (corners.size() < 3) return leave_out("faces of fewer than three corners");
  auto& triangles = result_.mesh.triangles;
  if (triangles.size() + corners.size() - 2 > most_triangles) {
    fail("has more than " + std::to_string(most_triangles) + " triangles; decimate the mesh");
  }
  if (corners.size() == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
  } else {
    cut_into_triangles(result_.mesh.vertices, corners, triangles);
  }
  const std::size_t before = result_.face.size();
  result_.face.resize(triangles.size(), static_cast<int>(face));
  if (texture.empty()) return;
  result_.mesh.texture.resize(before, no_texture);
  for (std::size_t t = before; t < triangles.size(); ++t) {
    CornerTexture& placed = result_.mesh.texture.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = std::find(corners.begin(), corners.end(), triangles[t][k]);
      placed[k] = texture[static_cast<std::size_t>(corner - corners.begin())];
    }
  }
}

/// Coordinates that some faces lack, or that are no numbers, would place nothing.
void MeshBuilder::require_whole_texture() {
  auto& texture = result_.mesh.texture;
  if (texture.empty()) return;
  texture.resize(result_.mesh.triangles.size(), no_texture);
  const auto missing = std::count_if(texture.begin(), texture.end(), [](const CornerTexture& t) {
    return !(t[0] + t[1] + t[2]).allFinite();
  });
  if (missing == 0) return;
  note("its texture coordinates are left out: " + std::to_string(missing) + " triangles have none");
  texture.clear();
}

void MeshBuilder::leave_out(const std::string& kind, std::size_t count) {
  if (count == 0) return;
  const auto known = std::find_if(left_out_.begin(), left_out_.end(),
                                  [&](const auto& one) { return one.first == kind; });
  if (known == left_out_.end()) {
    left_out_.emplace_back(kind, count);
  } else {
    known->second += count;
  }
}

std::string MeshBuilder::left_out() const {
  std::string list;
  for (const auto& [kind, count] : left_out_) {
    list += (list.empty() ? "" : ", ") + kind + " (" + std::to_string(count) + ")";
  }
  return list;
}

FileMesh MeshBuilder::take() {
  const std::string left = left_out();
  if (result_.mesh.triangles.empty()) {
    fail("has no triangles" + (left.empty() ? "" : " but " + left + ", which bound nothing") +
         "; give a closed triangle mesh");
  }
  require_whole_texture();
  if (!left.empty()) note("left out what bounds nothing: " + left);
  const double size = bounding_box(result_.mesh).sizes().maxCoeff();
  constexpr double coarsest = 1e-4;  // of the box: edges of 1/250 are then right to 2.5 %
  if (step_ > coarsest * size) {
    fail("is so far from its origin that its 32-bit numbers are " + shown_number(step_, "%.2g") +
         " apart, where it is " + shown_number(size, "%.2g") +
         " long; move it to the origin before export, or export numbers of 64 bits");
  }
  return std::move(result_);
}

double float_step(const Eigen::Vector3d& position) {
  return position.cwiseAbs().maxCoeff() * 0x1p-23;
}

}  // namespace kappamu::io
