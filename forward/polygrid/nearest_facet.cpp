#include "forward/polygrid/nearest_facet.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

/// Barycentric weights of the triangle's point nearest to p (Ericson 2005, 5.1.5).
Vector3d nearest_weights(const Facet& facet, const Vector3d& p) {
  const auto& [a, b, c] = facet;
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return {1, 0, 0};
  if (d3 >= 0.0 && d4 <= d3) return {0, 1, 0};
  if (d6 >= 0.0 && d5 <= d6) return {0, 0, 1};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / (d4 - d3 + d5 - d6);
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

std::vector<Eigen::AlignedBox3d> boxes_of(const std::vector<Facet>& facets) {
  std::vector<Eigen::AlignedBox3d> boxes(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    for (const Vector3d& p : facets[i]) boxes[i].extend(p);
  }
  return boxes;
}

Vector3d at(const Facet& facet, const Vector3d& weights) {
  return weights[0] * facet[0] + weights[1] * facet[1] + weights[2] * facet[2];
}

}  // namespace

std::vector<Facet> facets_of(const TriangleMesh& mesh) {
  std::vector<Facet> facets;
  for (const auto& triangle : mesh.triangles) {
    Facet facet;
    for (std::size_t i = 0; i < 3; ++i) {
      facet[i] = mesh.vertices[static_cast<std::size_t>(triangle[i])];
    }
    facets.push_back(facet);
  }
  return facets;
}

Facets::Facets(std::vector<Facet> facets, double near)
    : facets_(std::move(facets)), tree_(boxes_of(facets_)), near_(near) {}

Facets::Nearest Facets::nearest(const Vector3d& p) const {
  for (double radius = near_;; radius *= 2.0) {
    Nearest best;
    double distance = radius * radius;
    bool found = false;
    tree_.visit(
        [&](const Eigen::AlignedBox3d& box) { return box.squaredExteriorDistance(p) < distance; },
        [&](int i) {
          const Facet& facet = facets_[static_cast<std::size_t>(i)];
          const Vector3d weights = nearest_weights(facet, p);
          const double d = (at(facet, weights) - p).squaredNorm();
          if (d >= distance) return;
          distance = d;
          best = {i, weights};
          found = true;
        });
    if (found) return best;
  }
}

Vector3d Facets::point(const Nearest& nearest) const {
  return at(facets_[static_cast<std::size_t>(nearest.facet)], nearest.weights);
}

}  // namespace kappamu::forward::polygrid
