#include "io/mesh/mesh_builder.h"

#include <algorithm>

#include "core/error.h"
#include "core/file_name.h"
#include "core/mesh/polygon.h"
#include "core/shown_text.h"

namespace kappamu::io {

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

void MeshBuilder::add_polygon(std::span<const int> corners, std::size_t face) {
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
  result_.face.resize(triangles.size(), static_cast<int>(face));
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
