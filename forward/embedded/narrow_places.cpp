#include "forward/embedded/narrow_places.h"

#include <algorithm>
#include <limits>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/surface_rays.h"

namespace kappamu::forward::embedded {

namespace {

/// Of a normal's largest component.
constexpr double least_aligned = 1.0 - 1e-6;
/// Product of two walls' normals: at a concave edge they do not face each other.
constexpr double facing = -0.5;
/// Slits narrower than this share of a cube are left bridged.
constexpr double hopeless = 0.125;

}  // namespace

NarrowPlaces::NarrowPlaces(const ObjectProblem& problem)
    : area_(problem.surface.area),
      gap_(problem.surface.size(), std::numeric_limits<double>::infinity()),
      thickness_(gap_.size()),
      slit_(gap_),
      aligned_(gap_.size()) {
  const SurfaceRays rays(problem);
  const std::vector<Eigen::Vector3d>& normal = problem.surface.normal;
  for_row_ranges(gap_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (const auto hit = rays.first_hit(t, normal[t])) {
        gap_[t] = hit->distance;
        const bool wall = normal[t].dot(normal[static_cast<std::size_t>(hit->triangle)]) < facing;
        if (wall) slit_[t] = hit->distance;
      }
      thickness_[t] = rays.thickness(t);
      aligned_[t] = normal[t].cwiseAbs().maxCoeff() > least_aligned ? 1 : 0;
    }
  });
}

std::vector<double> NarrowPlaces::edges(const CutMesh& mesh) const {
  std::vector<double> edge(gap_.size(), 0.0);
  for (const CutMesh::Piece& piece : mesh.pieces) {
    double& h = edge[static_cast<std::size_t>(piece.triangle)];
    h = std::max(h, mesh.h(static_cast<std::size_t>(piece.cube)));
  }
  return edge;
}

std::vector<double> NarrowPlaces::errors_per_difference(const CutMesh& mesh) const {
  const std::vector<double> edge = edges(mesh);
  std::vector<double> result;
  for (std::size_t t = 0; t < edge.size(); ++t) {
    result.push_back(1.0 / (gap_[t] < edge[t]               ? difference_per_error_bridged
                            : thickness_[t] < 2.0 * edge[t] ? difference_per_error_thin
                            : gap_[t] < 2.0 * edge[t]       ? difference_per_error_half_bridged
                            : aligned_[t] != 0              ? difference_per_error_aligned
                                                            : difference_per_error));
  }
  return result;
}

double NarrowPlaces::bridged_area(const CutMesh& mesh) const {
  const std::vector<double> edge = edges(mesh);
  double sum = 0.0;
  for (std::size_t t = 0; t < edge.size(); ++t) {
    if (slit_[t] < edge[t]) sum += area_[t];
  }
  return sum;
}

std::vector<int> NarrowPlaces::bridging_cubes(const CutMesh& mesh) const {
  std::vector<int> result;
  for (const CutMesh::Piece& piece : mesh.pieces) {
    const double slit = slit_[static_cast<std::size_t>(piece.triangle)];
    const double h = mesh.h(static_cast<std::size_t>(piece.cube));
    if (slit >= h || slit < hopeless * h) continue;
    if (result.empty() || result.back() != piece.cube) result.push_back(piece.cube);
  }
  return result;
}

std::vector<int> NarrowPlaces::thin_leaves(const CutMesh& mesh) const {
  std::vector<int> result;
  for (const CutMesh::Piece& piece : mesh.pieces) {
    const auto cube = static_cast<std::size_t>(piece.cube);
    if (thickness_[static_cast<std::size_t>(piece.triangle)] >= mesh.h(cube)) continue;
    if (result.empty() || result.back() != mesh.leaf[cube]) result.push_back(mesh.leaf[cube]);
  }
  return result;
}

}  // namespace kappamu::forward::embedded
