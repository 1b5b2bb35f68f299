#include "forward/embedded/refinement.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kappamu::forward::embedded {

namespace {

/// |∫ n dA| / ∫ dA is 1 on a plane, 0.58 about a cube's corner, 0 between a sheet's two sides.
constexpr double folded = 0.5;

/// Mean over the cube of the gradient of the trilinear function [1/mm].
Eigen::Vector3d mean_gradient(const std::array<double, 8>& values, double h) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gradient[static_cast<Eigen::Index>(axis)] +=
          ((i >> axis & 1) != 0 ? 1.0 : -1.0) * values[i] / (4.0 * h);
    }
  }
  return gradient;
}

}  // namespace

Folds folds(const CutMesh& mesh, const Surface& surface) {
  Folds found;
  for (std::size_t k = 0; k < mesh.pieces.size();) {
    const int cube = mesh.pieces[k].cube;
    double area = 0.0, outward = 0.0;                     // ∫ dA, ∫ n·x dA
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();     // ∫ n dA
    Eigen::Vector3d position = Eigen::Vector3d::Zero();   // ∫ x dA, in the cube
    for (; k < mesh.pieces.size() && mesh.pieces[k].cube == cube; ++k) {
      const Eigen::Vector3d& n = surface.normal[static_cast<std::size_t>(mesh.pieces[k].triangle)];
      for (std::size_t i = 0; i < 8; ++i) {
        const double weight = static_cast<double>(mesh.pieces[k].weight[i]);
        const Eigen::Vector3d corner(i & 1, i >> 1 & 1, i >> 2 & 1);
        area += weight;
        normal += weight * n;
        position += weight * corner;
        outward += weight * n.dot(corner);
      }
    }
    if (normal.norm() >= folded * area) continue;
    found.leaf.push_back(mesh.leaf[static_cast<std::size_t>(cube)]);
    // About the pieces' centroid, normals of a sheet point away from each other, of a slit towards.
    if (outward - normal.dot(position) / area < 0.0) ++found.slits;
  }
  return found;
}

Indicator gradient_indicator(const Octree& tree, const CutMesh& mesh, const NodeSpace& space,
                             const std::vector<Coefficients>& coefficients,
                             const std::vector<std::vector<double>>& fluence) {
  Indicator result;
  for (const std::vector<double>& field : fluence) {
    Indicator mine;
    double total = 0.0;
    for (std::size_t k = 0; k < mesh.cubes.size();) {
      const auto parent_of = [&](std::size_t cube) { return tree.parent(mesh.leaf[cube]); };
      const int parent = parent_of(k);
      double weight = 0.0, squares = 0.0;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (; k < mesh.cubes.size() && parent_of(k) == parent; ++k) {
        const double h = mesh.h(k);
        const double share = coefficients[k].kappa * h * h * h * mesh.fraction(k);
        const Eigen::Vector3d gradient = mean_gradient(corner_values(space, k, field), h);
        weight += share;
        sum += share * gradient;
        squares += share * gradient.squaredNorm();
      }
      mine.node.push_back(parent);
      mine.value.push_back(weight > 0.0 ? std::max(0.0, squares - sum.squaredNorm() / weight)
                                        : 0.0);
      total += mine.value.back();
    }
    if (result.node.empty()) {
      result.node = mine.node;
      result.value.assign(mine.node.size(), 0.0);
    }
    for (std::size_t i = 0; i < mine.value.size() && total > 0.0; ++i) {
      result.value[i] += mine.value[i] / total;
    }
  }
  return result;
}

std::vector<int> largest(const Indicator& indicator, double share) {
  std::vector<std::size_t> order(indicator.node.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return indicator.value[a] > indicator.value[b];
  });
  const double wanted =
      share * std::accumulate(indicator.value.begin(), indicator.value.end(), 0.0);
  std::vector<int> nodes;
  double sum = 0.0;
  for (std::size_t k = 0; k < order.size() && sum < wanted; ++k) {
    sum += indicator.value[order[k]];
    nodes.push_back(indicator.node[order[k]]);
  }
  return nodes;
}

}  // namespace kappamu::forward::embedded
