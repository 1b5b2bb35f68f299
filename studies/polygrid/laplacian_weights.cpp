#include "studies/polygrid/laplacian_weights.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <limits>
#include <map>
#include <tuple>

namespace kappamu::studies {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double most_condition = 1e4;

Vector3d beside(const NodeGrid& grid, int link) {
  return link >= 0 ? grid.node[static_cast<std::size_t>(link)]
                   : grid.boundary_node[static_cast<std::size_t>(~link)];
}

/// Vectors along a node's links [mm].
std::array<Vector3d, 6> along_links(const NodeGrid& grid, std::size_t node) {
  std::array<Vector3d, 6> along;
  for (std::size_t s = 0; s < 6; ++s) along[s] = beside(grid, grid.link[node][s]) - grid.node[node];
  return along;
}

/// The rotation nearest to the directions of opposite links.
Matrix3d frame_of(const std::array<Vector3d, 6>& along) {
  Matrix3d axes;
  for (std::size_t a = 0; a < 3; ++a) {
    axes.col(static_cast<Eigen::Index>(a)) = (along[2 * a + 1] - along[2 * a]).normalized();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

std::array<double, 6> flux_weights(const std::array<Vector3d, 6>& along) {
  std::array<double, 6> weights{};
  for (std::size_t s = 0; s < 6; ++s) {
    const double extent = 0.5 * (along[s].norm() + along[s ^ 1].norm());
    weights[s] = 1.0 / (extent * along[s].norm());
  }
  return weights;
}

/// Rows and columns scaled to lengths of one, so that the condition is that of the shape.
double condition(const Matrix6& system) {
  const Eigen::JacobiSVD<Matrix6> svd(system);
  const auto& values = svd.singularValues();
  return values[5] > 0.0 ? values[0] / values[5] : std::numeric_limits<double>::infinity();
}

}  // namespace

NodeGrid node_grid(const Polygrid& grid) {
  NodeGrid result;
  result.node = grid.node;
  result.link = grid.link;
  result.boundary_node = grid.boundary_node;
  result.boundary_cell = grid.boundary_cell;
  result.place = grid.cell;
  // A block without a layer has nodes with several boundary nodes, and none with an outer side.
  bool layered = true;
  std::vector<int> outer(grid.cell.size(), -1);
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    int& side = outer[static_cast<std::size_t>(grid.boundary_cell[b])];
    layered = layered && side < 0;
    side = grid.boundary_side[b];
  }
  result.outer_side = layered ? outer : std::vector<int>(grid.cell.size(), -1);
  return result;
}

NodeGrid coarser(NodeGrid& fine) {
  NodeGrid coarse;
  std::map<std::tuple<int, int, int, int>, int> number;
  std::vector<double> children;
  fine.parent.clear();
  for (std::size_t k = 0; k < fine.node.size(); ++k) {
    const Vector3i at(fine.place[k][0] >> 1, fine.place[k][1] >> 1, fine.place[k][2] >> 1);
    const auto [found, made] = number.try_emplace({at[2], at[1], at[0], fine.outer_side[k]},
                                                  static_cast<int>(coarse.node.size()));
    const auto parent = static_cast<std::size_t>(found->second);
    if (made) {
      coarse.node.push_back(Vector3d::Zero());
      coarse.place.push_back(at);
      coarse.outer_side.push_back(fine.outer_side[k]);
      children.push_back(0.0);
    }
    coarse.node[parent] += fine.node[k];
    children[parent] += 1.0;
    fine.parent.push_back(static_cast<int>(parent));
  }
  for (std::size_t k = 0; k < coarse.node.size(); ++k) coarse.node[k] /= children[k];
  constexpr int none = std::numeric_limits<int>::max();
  coarse.link.assign(coarse.node.size(), {none, none, none, none, none, none});
  std::vector<double> of_boundary;
  fine.boundary_parent.assign(fine.boundary_node.size(), 0);
  for (std::size_t k = 0; k < fine.node.size(); ++k) {
    const auto parent = static_cast<std::size_t>(fine.parent[k]);
    for (std::size_t s = 0; s < 6; ++s) {
      const int link = fine.link[k][s];
      int& mine = coarse.link[parent][s];
      if (link >= 0) {
        const int other = fine.parent[static_cast<std::size_t>(link)];
        if (other != fine.parent[k] && (mine == none || mine < 0)) mine = other;
        continue;
      }
      if (mine == none) {
        mine = ~static_cast<int>(coarse.boundary_node.size());
        coarse.boundary_node.push_back(Vector3d::Zero());
        coarse.boundary_cell.push_back(static_cast<int>(parent));
        of_boundary.push_back(0.0);
      }
      if (mine >= 0) continue;
      const auto b = static_cast<std::size_t>(~mine);
      coarse.boundary_node[b] += fine.boundary_node[static_cast<std::size_t>(~link)];
      of_boundary[b] += 1.0;
      fine.boundary_parent[static_cast<std::size_t>(~link)] = static_cast<int>(b);
    }
  }
  for (std::size_t b = 0; b < of_boundary.size(); ++b) coarse.boundary_node[b] /= of_boundary[b];
  return coarse;
}

LaplacianWeights laplacian_weights(const NodeGrid& grid, NegativeWeights negative) {
  LaplacianWeights result;
  result.weight.resize(grid.node.size());
  result.kind.assign(grid.node.size(), WeightKind::paper);
  for (std::size_t k = 0; k < grid.node.size(); ++k) {
    const std::array<Vector3d, 6> along = along_links(grid, k);
    double size = 0.0;
    for (const Vector3d& v : along) size += v.norm() / 6.0;
    const Matrix3d to_local = frame_of(along).transpose();
    Matrix6 system;
    for (Eigen::Index j = 0; j < 6; ++j) {
      const Vector3d d = to_local * along[static_cast<std::size_t>(j)] / size;
      system.row(j) << d[0], 0.5 * d[0] * d[0], d[1], 0.5 * d[1] * d[1], d[2], 0.5 * d[2] * d[2];
    }
    if (condition(system) > most_condition) {
      result.kind[k] = WeightKind::ill_conditioned;
      ++result.ill_conditioned;
    } else {
      const Matrix6 inverse = system.inverse();
      const Eigen::Matrix<double, 1, 6> sum = inverse.row(1) + inverse.row(3) + inverse.row(5);
      for (std::size_t j = 0; j < 6; ++j) {
        result.weight[k][j] = sum[static_cast<Eigen::Index>(j)] / (size * size);
      }
      if ((sum.array() < 0.0).any()) {
        result.kind[k] = WeightKind::negative;
        ++result.negative;
      }
    }
    const bool unusable =
        result.kind[k] == WeightKind::ill_conditioned ||
        (negative == NegativeWeights::replaced && result.kind[k] == WeightKind::negative);
    if (unusable) result.weight[k] = flux_weights(along);
  }
  return result;
}

}  // namespace kappamu::studies
