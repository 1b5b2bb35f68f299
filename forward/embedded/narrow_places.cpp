#include "forward/embedded/narrow_places.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "forward/surface_rays.h"

namespace kappamu::forward::embedded {

namespace {

/// Of a normal's largest component.
constexpr double least_aligned = 1.0 - 1e-6;
/// Product of two walls' normals: at a concave edge they do not face each other.
constexpr double facing = -0.5;
/// Slits narrower than this share of a cube are left bridged.
constexpr double hopeless = 0.125;

/// Where between the lower and the upper side of the parent of the piece's cube, from 0 to 1.
double place_in_parent(const CutMesh& mesh, const CutMesh::Piece& piece, int axis) {
  double upper = 0.0, all = 0.0;
  for (std::size_t corner = 0; corner < piece.weight.size(); ++corner) {
    all += piece.weight[corner];
    if ((corner >> axis) % 2 == 1) upper += piece.weight[corner];
  }
  const Cube& cube = mesh.cubes[static_cast<std::size_t>(piece.cube)];
  return all > 0.0 ? 0.5 * (cube.at[static_cast<std::size_t>(axis)] % 2 + upper / all) : 0.5;
}

/// Of a face along the cubes.
double difference_per_error_at(double place) {
  const double clear = std::min(1.0, std::abs(place - 0.5) / clear_of_half);
  return difference_per_error_halved +
         clear * (difference_per_error_along - difference_per_error_halved);
}

}  // namespace

NarrowPlaces::NarrowPlaces(const ObjectProblem& problem)
    : area_(problem.surface.area),
      gap_(problem.surface.size(), std::numeric_limits<double>::infinity()),
      thickness_(gap_.size()),
      slit_(gap_),
      axis_(gap_.size()) {
  const SurfaceRays rays(problem);
  const std::vector<Eigen::Vector3d>& normal = problem.surface.normal;
  for_ranges(gap_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (const auto hit = rays.first_hit(t, normal[t])) {
        gap_[t] = hit->distance;
        const bool wall = normal[t].dot(normal[static_cast<std::size_t>(hit->triangle)]) < facing;
        if (wall) slit_[t] = hit->distance;
      }
      thickness_[t] = rays.thickness(t);
      int axis = 0;
      if (normal[t].cwiseAbs().maxCoeff(&axis) > least_aligned) axis_[t] = axis;
    }
  });
}

std::vector<const CutMesh::Piece*> NarrowPlaces::largest_pieces(const CutMesh& mesh) const {
  std::vector<const CutMesh::Piece*> largest(gap_.size(), nullptr);
  const auto h = [&](const CutMesh::Piece& piece) {
    return mesh.h(static_cast<std::size_t>(piece.cube));
  };
  for (const CutMesh::Piece& piece : mesh.pieces) {
    const CutMesh::Piece*& is = largest[static_cast<std::size_t>(piece.triangle)];
    if (!is || h(piece) > h(*is)) is = &piece;
  }
  return largest;
}

std::vector<double> NarrowPlaces::edges(const CutMesh& mesh) const {
  std::vector<double> edge;
  for (const CutMesh::Piece* piece : largest_pieces(mesh)) {
    edge.push_back(piece ? mesh.h(static_cast<std::size_t>(piece->cube)) : 0.0);
  }
  return edge;
}

std::vector<double> NarrowPlaces::errors_per_difference(const CutMesh& mesh) const {
  const std::vector<const CutMesh::Piece*> piece = largest_pieces(mesh);
  const std::vector<double> edge = edges(mesh);
  std::vector<double> result;
  for (std::size_t t = 0; t < edge.size(); ++t) {
    double least = difference_per_error;
    const auto at_most = [&](double divisor) { least = std::min(least, divisor); };
    if (axis_[t] && piece[t]) {
      at_most(difference_per_error_at(place_in_parent(mesh, *piece[t], *axis_[t])));
    }
    if (gap_[t] < 2.0 * edge[t]) at_most(difference_per_error_half_bridged);
    if (thickness_[t] < 2.0 * edge[t]) at_most(difference_per_error_thin);
    if (gap_[t] < edge[t]) at_most(difference_per_error_bridged);
    result.push_back(1.0 / least);
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
