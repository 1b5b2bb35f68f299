#include "forward/polygrid/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/numbers/at.h"

namespace kappamu::forward {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

namespace {

/// Of a point from a box; 0 within.
double squared_distance(const Vector3d& point, const Vector3d& low, const Vector3d& high) {
  const Vector3d off = (low - point).cwiseMax(point - high).cwiseMax(0.0);
  return off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
}

std::vector<AlignedBox3d> boxes_of(const TriangleMesh& mesh) {
  std::vector<AlignedBox3d> boxes;
  for (const auto& t : mesh.triangles) {
    AlignedBox3d box;
    for (const int v : t) box.extend(mesh.vertices[at(v)]);
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace

Vector3d closest_weights(const Vector3d& point, const Vector3d& a, const Vector3d& b,
                         const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = point - a, bp = point - b, cp = point - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double v = d1 / (d1 - d3);
    return {1.0 - v, v, 0.0};
  }
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double w = d2 / (d2 - d6);
    return {1.0 - w, 0.0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0.0, 1.0 - w, w};
  }
  return Vector3d(va, vb, vc) / (va + vb + vc);
}

ClosestPoint::ClosestPoint(const TriangleMesh& mesh)
    : mesh_(mesh), tree_(boxes_of(mesh)), vertex_normal_(mesh.vertices.size(), Vector3d::Zero()) {
  for (const auto& t : mesh.triangles) {
    const std::array<Vector3d, 3> v{mesh.vertices[at(t[0])], mesh.vertices[at(t[1])],
                                    mesh.vertices[at(t[2])]};
    corners_.push_back(v);
    normal_.push_back((v[1] - v[0]).cross(v[2] - v[0]).stableNormalized());
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d a = (v[(k + 1) % 3] - v[k]).stableNormalized();
      const Vector3d b = (v[(k + 2) % 3] - v[k]).stableNormalized();
      vertex_normal_[at(t[k])] += std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * normal_.back();
    }
  }
  for (Vector3d& normal : vertex_normal_) normal = normal.stableNormalized();
}

ClosestPoint::Found ClosestPoint::from(const Vector3d& point, int near, double enough) const {
  Found best;
  const auto look_at = [&](int triangle) {
    const auto& [a, b, c] = corners_[at(triangle)];
    const Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    if (squared_distance(point, low, high) > best.distance) return;
    const Vector3d weights = closest_weights(point, a, b, c);
    const Vector3d there = weights[0] * a + weights[1] * b + weights[2] * c;
    const double squared = (there - point).squaredNorm();
    if (squared < best.distance || (squared == best.distance && triangle < best.triangle)) {
      best = {triangle, weights, there, squared};
    }
  };
  best.distance = std::numeric_limits<double>::infinity();
  const double ends = enough > 0.0 ? enough * enough : -1.0;
  look_at(near);
  tree_.visit_nearest(
      [&](const AlignedBox3d& box) { return squared_distance(point, box.min(), box.max()); },
      [&] { return best.distance > ends ? best.distance : -1.0; }, look_at);
  best.distance = std::sqrt(best.distance);
  return best;
}

Vector3d ClosestPoint::smooth_normal(const Found& found) const {
  const auto& t = mesh_.triangles[at(found.triangle)];
  const Vector3d smooth = found.weights[0] * vertex_normal_[at(t[0])] +
                          found.weights[1] * vertex_normal_[at(t[1])] +
                          found.weights[2] * vertex_normal_[at(t[2])];
  return smooth.squaredNorm() > 0.0 ? Vector3d(smooth.stableNormalized()) : normal(found.triangle);
}

const Vector3d& ClosestPoint::normal(int triangle) const {
  return normal_[at(triangle)];
}

}  // namespace kappamu::forward
