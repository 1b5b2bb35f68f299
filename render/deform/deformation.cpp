#include "render/deform/deformation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/error.h"
#include "core/mesh/crossings.h"
#include "core/numbers/noise.h"
#include "core/parallel.h"
#include "core/shown_text.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;
using Move = std::function<Vector3d(std::size_t vertex)>;  ///< where a point of weight 1 goes

constexpr double degree = std::numbers::pi / 180.0;
/// Of a triangle pressed flat: its area over the longest edge of the box squared (mesh_check.h).
constexpr double flat_area = 1e-12;

std::vector<Vector3d> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vector3d> normals(mesh.vertices.size(), Vector3d::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b),
               k = static_cast<std::size_t>(c);
    const Vector3d normal =
        (mesh.vertices[j] - mesh.vertices[i]).cross(mesh.vertices[k] - mesh.vertices[i]);
    for (const std::size_t v : {i, j, k}) normals[v] += normal;
  }
  for (Vector3d& normal : normals) normal.normalize();
  return normals;
}

/// The stretch of an axis over which a twist or a bend takes place.
struct Stretch {
  Vector3d axis, centre;
  double length;

  double place(const Vector3d& point) const { return axis.dot(point - centre); }
  double inside(const Vector3d& point) const {
    return std::clamp(place(point), -0.5 * length, 0.5 * length);
  }
};

Stretch stretch_of(const TriangleMesh& mesh, const Deformation& d) {
  Stretch stretch{d.axis.value_or(Vector3d::UnitY()), d.centre_mm, d.length_mm.value_or(0.0)};
  if (d.length_mm) return stretch;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector3d& vertex : mesh.vertices) {
    low = std::min(low, stretch.place(vertex));
    high = std::max(high, stretch.place(vertex));
  }
  stretch.length = high - low;
  stretch.centre += 0.5 * (low + high) * stretch.axis;
  return stretch;
}

/// The middle of the stretch stays; its ends turn by half of the angle each way.
Vector3d twisted(const Stretch& s, double angle, const Vector3d& point) {
  return s.centre +
         Eigen::AngleAxisd(angle * s.inside(point) / s.length, s.axis) * (point - s.centre);
}

/// The stretch becomes an arc; beyond it the object goes on straight.
Vector3d bent(const Stretch& s, double angle, const Vector3d& towards, const Vector3d& point) {
  const double curvature = angle / s.length, along = s.inside(point), turn = curvature * along;
  if (angle == 0.0) return point;
  const double half = std::sin(0.5 * turn);
  const double aside = towards.dot(point - s.centre), beyond = s.place(point) - along;
  const double on_axis =
      std::sin(turn) / curvature - aside * std::sin(turn) + beyond * std::cos(turn);
  const double off_axis =
      2.0 * half * half / curvature + aside * std::cos(turn) + beyond * std::sin(turn);
  return point + (on_axis - s.place(point)) * s.axis + (off_axis - aside) * towards;
}

/// Along the mean normal of what the brush holds, inwards.
Vector3d inwards(const std::vector<Vector3d>& normals, const TriangleMesh& mesh,
                 const DeformBrush& brush) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t v = 0; v < normals.size(); ++v) {
    sum += brush.weight(mesh.vertices[v]) * normals[v];
  }
  if (sum.norm() < 1e-12) {
    throw InputError("brush holds no vertex of the surface; move its centre_mm or widen it");
  }
  return -sum.normalized();
}

Move move_of(const TriangleMesh& mesh, const Deformation& d) {
  const Vector3d axis = d.axis.value_or(Vector3d::UnitY());
  const auto& at = mesh.vertices;
  switch (d.kind) {
    case DeformKind::pull:
      return [&at, by = Vector3d(d.amount * axis)](std::size_t v) { return at[v] + by; };
    case DeformKind::dent: {
      const Vector3d by = d.amount * inwards(vertex_normals(mesh), mesh, *d.brush);
      return [&at, by](std::size_t v) { return at[v] + by; };
    }
    case DeformKind::twist:
      return [&at, s = stretch_of(mesh, d), angle = degree * d.amount](std::size_t v) {
        return twisted(s, angle, at[v]);
      };
    case DeformKind::bend: {
      const Vector3d towards = (d.towards - d.towards.dot(axis) * axis).normalized();
      return [&at, s = stretch_of(mesh, d), angle = degree * d.amount, towards](std::size_t v) {
        return bent(s, angle, towards, at[v]);
      };
    }
    case DeformKind::inflate:
      return [&at, normals = vertex_normals(mesh), by = d.amount](std::size_t v) {
        return Vector3d(at[v] + by * normals[v]);
      };
    case DeformKind::noise:
      return [&at, normals = vertex_normals(mesh), &d](std::size_t v) {
        const Vector3d place = (at[v] + d.offset_mm) / d.wavelength_mm;
        return Vector3d(at[v] + d.amount * value_noise(place, d.seed) * normals[v]);
      };
    case DeformKind::scale:
      break;
  }
  return [&at, &d, axis](std::size_t v) {
    const Vector3d from = at[v] - d.centre_mm;
    const Vector3d grown = d.axis ? Vector3d(axis.dot(from) * axis) : from;
    return Vector3d(at[v] + (d.amount - 1.0) * grown);
  };
}

void deform(TriangleMesh& mesh, const Deformation& deformation) {
  const Move move = move_of(mesh, deformation);
  std::vector<Vector3d> moved(mesh.vertices.size());
  for_pieces(moved.size(), 4096, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Vector3d& from = mesh.vertices[v];
      const double weight = deformation.brush ? deformation.brush->weight(from) : 1.0;
      moved[v] = weight > 0.0 ? Vector3d(from + weight * (move(v) - from)) : from;
    }
  });
  mesh.vertices = std::move(moved);
}

std::uint64_t crossings_of(const TriangleMesh& mesh) {
  const auto pairs = MeshCrossings(mesh).crossing_pairs(std::vector<int>(mesh.triangles.size(), 0));
  return pairs.all ? pairs.count : std::numeric_limits<std::uint64_t>::max();
}

/// What is wrong with a deformed body; empty: nothing.
std::string fault_of(const TriangleMesh& mesh, const TriangleMesh& rest) {
  const double size = bounding_box(mesh).sizes().maxCoeff();
  const Surface surface = surface_of(mesh);
  for (std::size_t t = 0; t < surface.size(); ++t) {
    if (!(surface.area[t] > flat_area * size * size)) {
      return "presses triangle " + std::to_string(t) + " flat";
    }
  }
  if (!(enclosed_volume(mesh) > 0.0)) return "turns the surface inside out";
  const std::uint64_t crossings = crossings_of(mesh);
  if (crossings > 0 && crossings > crossings_of(rest)) return "makes the surface cross itself";
  return "";
}

}  // namespace

double DeformBrush::weight(const Vector3d& point) const {
  const double within = 1.0 - (point - centre_mm).norm() / radius_mm;
  if (within <= 0.0) return 0.0;
  if (within >= edge) return 1.0;
  const double s = within / edge;
  return s * s * (3.0 - 2.0 * s);
}

DeformAmount amount_of(DeformKind kind) {
  if (kind == DeformKind::twist) return {"degrees", -3600.0, 3600.0};
  if (kind == DeformKind::bend) return {"degrees", -360.0, 360.0};
  if (kind == DeformKind::scale) return {"factor", 0.01, 100.0};
  return {"mm", -1e6, 1e6};
}

std::string described(const Deformation& deformation) {
  const std::string unit = amount_of(deformation.kind).name;
  const std::string number = formatted("%g", deformation.amount);
  return name_of(deform_kinds, deformation.kind) + " of " +
         (unit == "factor" ? unit + " " + number : number + " " + unit);
}

TriangleMesh deformed(TriangleMesh mesh, std::span<const Deformation> deformations) {
  for (const Deformation& deformation : deformations) {
    try {
      deform(mesh, deformation);
    } catch (const InputError& error) {
      throw InputError(described(deformation) + ": its " + error.what());
    }
  }
  return mesh;
}

TriangleMesh deformed_body(const TriangleMesh& rest, std::span<const Deformation> deformations) {
  TriangleMesh body = deformed(rest, deformations);
  if (deformations.empty() || fault_of(body, rest).empty()) return body;
  for (std::size_t i = 0;; ++i) {
    const std::string fault = fault_of(deformed(rest, deformations.first(i + 1)), rest);
    if (fault.empty()) continue;
    throw InputError("deform[" + std::to_string(i) + "], " + described(deformations[i]) + ", " +
                     fault + "; reduce its " + amount_of(deformations[i].kind).name);
  }
}

}  // namespace kappamu::render
