#include "core/mesh/crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <random>

#include "core/parallel.h"

namespace kappamu {

namespace {

using Eigen::Vector3d;

/// Pairs looked at, where a mesh of a body has some ten.
constexpr std::uint64_t most_looks_per_triangle = 1000;

/// Distances below this share of the box are touching: within a component, and between two, whose
/// files may round positions to 24 bits.
constexpr double touching = 1e-9, touching_between = 1e-6;

std::vector<Eigen::AlignedBox3d> boxes_of(const TriangleMesh& mesh) {
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (const int v : triangle) box.extend(mesh.vertices[static_cast<std::size_t>(v)]);
  }
  return boxes;
}

using Corners = std::array<Vector3d, 3>;

Vector3d unit_normal(const Corners& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

/// The segment crosses the triangle's inside from one side to the other.
bool pierces(const Vector3d& from, const Vector3d& to, const Corners& t, const Vector3d& normal,
             double tolerance) {
  const double before = normal.dot(from - t[0]), after = normal.dot(to - t[0]);
  if (!((before > tolerance && after < -tolerance) || (before < -tolerance && after > tolerance))) {
    return false;
  }
  const Vector3d point = from + before / (before - after) * (to - from);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d edge = t[(k + 1) % 3] - t[k];
    if (normal.dot(edge.cross(point - t[k])) <= tolerance * edge.norm()) return false;
  }
  return true;
}

/// In one plane, and more than touching there: no edge of either separates them.
bool lies_upon(const Corners& one, const Corners& other, const Vector3d& normal, double tolerance) {
  for (const Vector3d& corner : other) {
    if (std::abs(normal.dot(corner - one[0])) > tolerance) return false;
  }
  for (const auto& [a, b] : {std::pair(&one, &other), std::pair(&other, &one)}) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d aside = ((*a)[(k + 1) % 3] - (*a)[k]).cross(normal).normalized();
      const double inside = aside.dot((*a)[(k + 2) % 3] - (*a)[k]);
      bool separates = true;
      for (const Vector3d& corner : *b) {
        const double reach = aside.dot(corner - (*a)[k]);
        separates = separates && (inside < 0.0 ? reach >= -tolerance : reach <= tolerance);
      }
      if (separates) return false;
    }
  }
  return true;
}

}  // namespace

MeshCrossings::MeshCrossings(const TriangleMesh& mesh)
    : mesh_(mesh),
      boxes_(boxes_of(mesh)),
      tree_(boxes_),
      length_(bounding_box(mesh).sizes().maxCoeff()) {}

const Vector3d& MeshCrossings::corner(int triangle, int k) const {
  const auto& corners = mesh_.triangles[static_cast<std::size_t>(triangle)];
  return mesh_.vertices[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])];
}

bool MeshCrossings::meets(const Eigen::AlignedBox3d& box, const Vector3d& origin,
                          const Vector3d& direction) {
  double enters = 0.0, leaves = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double one = (box.min()[axis] - origin[axis]) / direction[axis];
    const double other = (box.max()[axis] - origin[axis]) / direction[axis];
    enters = std::fmax(enters, std::fmin(one, other));
    leaves = std::fmin(leaves, std::fmax(one, other));
  }
  return enters <= leaves * (1.0 + 1e-12);
}

int MeshCrossings::crosses(int triangle, const Vector3d& origin, const Vector3d& direction) const {
  // Signs of the volumes that the ray's line spans with each edge, at the ray's origin.
  const Vector3d a = corner(triangle, 0) - origin, b = corner(triangle, 1) - origin,
                 c = corner(triangle, 2) - origin;
  const double ab = direction.dot(a.cross(b)), bc = direction.dot(b.cross(c)),
               ca = direction.dot(c.cross(a));
  const bool with = ab > 0.0 && bc > 0.0 && ca > 0.0;
  if (!with && !(ab < 0.0 && bc < 0.0 && ca < 0.0)) return 0;
  const double height =
      a.dot((b - a).cross(c - a));  // times the area: of the plane over the origin
  if (with ? height <= 0.0 : height >= 0.0) return 0;  // behind
  return with ? 1 : -1;
}

bool MeshCrossings::triangles_cross(int one, int other, bool between) const {
  int shared = 0;
  for (const int v : mesh_.triangles[static_cast<std::size_t>(one)]) {
    for (const int w : mesh_.triangles[static_cast<std::size_t>(other)]) shared += v == w ? 1 : 0;
  }
  const Corners s{corner(one, 0), corner(one, 1), corner(one, 2)};
  const Corners t{corner(other, 0), corner(other, 1), corner(other, 2)};
  const Vector3d s_normal = unit_normal(s), t_normal = unit_normal(t);
  const double tolerance = touching * length_;
  for (std::size_t k = 0; k < 3 && shared < 2; ++k) {
    if (pierces(s[k], s[(k + 1) % 3], t, t_normal, tolerance) ||
        pierces(t[k], t[(k + 1) % 3], s, s_normal, tolerance)) {
      return true;
    }
  }
  // In the plane of the larger one: rounded corners tilt that of a small one.
  const auto area = [](const Corners& c) { return (c[1] - c[0]).cross(c[2] - c[0]).norm(); };
  const double near = (between ? touching_between : touching) * length_;
  return area(s) >= area(t) ? lies_upon(s, t, s_normal, near) : lies_upon(t, s, t_normal, near);
}

MeshCrossings::Pairs MeshCrossings::crossing_pairs(const std::vector<int>& component) const {
  const auto keep_first = [](std::optional<std::pair<int, int>>& first,
                             const std::optional<std::pair<int, int>>& found) {
    if (found && (!first || *found < *first)) first = found;
  };
  constexpr std::size_t piece = 1024;
  const std::uint64_t most_looks = most_looks_per_triangle * boxes_.size();
  Pairs pairs;
  std::uint64_t looks = 0;
  std::mutex lock;
  for_rows(static_cast<int>((boxes_.size() + piece - 1) / piece), [&](int row) {
    Pairs here;
    std::uint64_t looks_here = 0;
    const std::size_t begin = static_cast<std::size_t>(row) * piece;
    for (std::size_t i = begin; i < std::min(begin + piece, boxes_.size()); ++i) {
      const int one = static_cast<int>(i);
      const Vector3d near = Vector3d::Constant(touching_between * length_);
      const Eigen::AlignedBox3d reach(boxes_[i].min() - near, boxes_[i].max() + near);
      tree_.visit(
          [&](const Eigen::AlignedBox3d& box) {
            return looks_here < most_looks && box.intersects(reach);
          },
          [&](int other) {
            if (other <= one || !reach.intersects(boxes_[static_cast<std::size_t>(other)])) {
              return;
            }
            ++looks_here;
            const bool between = component[i] != component[static_cast<std::size_t>(other)];
            if (!triangles_cross(one, other, between)) return;
            ++here.count;
            const std::pair found(one, other);
            keep_first(here.first, found);
            if (between) keep_first(here.between, found);
          });
    }
    const std::lock_guard guard(lock);
    looks += looks_here;
    pairs.count += here.count;
    keep_first(pairs.first, here.first);
    keep_first(pairs.between, here.between);
    pairs.all = looks < most_looks;
  });
  return pairs;
}

double MeshCrossings::hidden_share() const {
  constexpr int points = 4096;
  std::vector<double> reach;  // running sum of areas
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const auto c = [&](int k) { return corner(static_cast<int>(t), k); };
    reach.push_back((reach.empty() ? 0.0 : reach.back()) + (c(1) - c(0)).cross(c(2) - c(0)).norm());
  }
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  int hidden = 0;
  for (int i = 0; i < points; ++i) {
    const double at = (i + uniform()) / points * reach.back();
    const auto found = std::upper_bound(reach.begin(), reach.end() - 1, at);
    const auto chosen = static_cast<int>(found - reach.begin());
    const Vector3d first = corner(chosen, 1) - corner(chosen, 0);
    const Vector3d second = corner(chosen, 2) - corner(chosen, 0);
    const double root = std::sqrt(uniform()), along_edge = uniform();
    const Vector3d origin =
        corner(chosen, 0) + root * ((1.0 - along_edge) * first + along_edge * second);
    Vector3d direction(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5);
    if (direction.dot(first.cross(second)) < 0.0) direction = -direction;
    const Crossings others = along(origin, direction, [&](int other) { return other != chosen; });
    hidden += others.winding == 0 ? 0 : 1;
  }
  return static_cast<double>(hidden) / points;
}

}  // namespace kappamu
