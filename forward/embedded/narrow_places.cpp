#include "forward/embedded/narrow_places.h"

#include <algorithm>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/surface_rays.h"

namespace kappamu::forward::embedded {

namespace {

/// Of a normal's largest component.
constexpr double least_aligned = 1.0 - 1e-6;

}  // namespace

NarrowPlaces::NarrowPlaces(const ObjectProblem& problem)
    : gap_(problem.surface.size()), thickness_(gap_.size()), aligned_(gap_.size()) {
  const SurfaceRays rays(problem);
  for_row_ranges(gap_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      gap_[t] = rays.gap(t);
      thickness_[t] = rays.thickness(t);
      aligned_[t] = problem.surface.normal[t].cwiseAbs().maxCoeff() > least_aligned ? 1 : 0;
    }
  });
}

std::vector<double> NarrowPlaces::errors_per_difference(const CutMesh& mesh) const {
  std::vector<double> edge(gap_.size(), 0.0);  // of the largest cube about each triangle [mm]
  for (const CutMesh::Piece& piece : mesh.pieces) {
    double& h = edge[static_cast<std::size_t>(piece.triangle)];
    h = std::max(h, mesh.h(static_cast<std::size_t>(piece.cube)));
  }
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
