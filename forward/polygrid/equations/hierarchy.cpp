#include "forward/polygrid/equations/hierarchy.h"

#include <algorithm>
#include <numeric>

#include "core/numbers/linear_algebra.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Nodes of a level with where they are.
struct Nodes {
  std::vector<Vector3i> place;
  std::vector<Vector3d> position;  ///< middle of its unknowns
  std::vector<double> weight;      ///< number of its unknowns
};

/// Distances of coarse nodes over those of fine ones that lie outside of this tell nothing.
constexpr double least_share = 0.5, most_share = 1.0;

/// Aggregates: equal halved places, one piece along links. Numbered by their first node.
std::vector<int> aggregates(const GraphLevel& level, const std::vector<Vector3i>& place) {
  std::vector<int> root(place.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[static_cast<std::size_t>(i)] != i) {
      root[static_cast<std::size_t>(i)] =
          root[static_cast<std::size_t>(root[static_cast<std::size_t>(i)])];
      i = root[static_cast<std::size_t>(i)];
    }
    return i;
  };
  const auto halved = [&](std::size_t i) {
    return Vector3i(place[i][0] >> 1, place[i][1] >> 1, place[i][2] >> 1);
  };
  for (std::size_t i = 0; i < place.size(); ++i) {
    for (int k = level.links.start[i]; k < level.links.start[i + 1]; ++k) {
      const int j = level.links.column[static_cast<std::size_t>(k)];
      if (halved(i) != halved(static_cast<std::size_t>(j))) continue;
      const int a = find(static_cast<int>(i)), b = find(j);
      root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  std::vector<int> parent(place.size());
  int count = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const int first = find(static_cast<int>(i));
    parent[i] = first == static_cast<int>(i) ? count++ : parent[static_cast<std::size_t>(first)];
  }
  return parent;
}

Nodes coarser_nodes(const Nodes& fine, const std::vector<int>& parent, std::size_t count) {
  Nodes coarse{std::vector<Vector3i>(count), std::vector<Vector3d>(count, Vector3d::Zero()),
               std::vector<double>(count, 0.0)};
  for (std::size_t i = 0; i < parent.size(); ++i) {
    const auto p = static_cast<std::size_t>(parent[i]);
    coarse.place[p] = Vector3i(fine.place[i][0] >> 1, fine.place[i][1] >> 1, fine.place[i][2] >> 1);
    coarse.position[p] += fine.weight[i] * fine.position[i];
    coarse.weight[p] += fine.weight[i];
  }
  for (std::size_t p = 0; p < count; ++p) coarse.position[p] /= coarse.weight[p];
  return coarse;
}

/// Links of the coarser level, and those of the finer that make them.
GraphLevel coarser_level(GraphLevel& fine, std::size_t count, const Nodes& nodes,
                         const Nodes& coarse_nodes) {
  std::vector<std::vector<int>> neighbours(count);
  for (std::size_t i = 0; i < fine.parent.size(); ++i) {
    for (int k = fine.links.start[i]; k < fine.links.start[i + 1]; ++k) {
      const int j = fine.links.column[static_cast<std::size_t>(k)];
      const auto [a, b] = std::minmax(fine.parent[i], fine.parent[static_cast<std::size_t>(j)]);
      if (a != b) neighbours[static_cast<std::size_t>(a)].push_back(b);
    }
  }
  GraphLevel coarse;
  for (std::vector<int>& row : neighbours) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    coarse.links.column.insert(coarse.links.column.end(), row.begin(), row.end());
    coarse.links.start.push_back(static_cast<int>(coarse.links.column.size()));
  }
  fine.coarse.assign(fine.links.column.size(), -1);
  fine.share.assign(fine.links.column.size(), 0.0);
  for (std::size_t i = 0; i < fine.parent.size(); ++i) {
    for (int k = fine.links.start[i]; k < fine.links.start[i + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const auto j = static_cast<std::size_t>(fine.links.column[at]);
      const auto a = static_cast<std::size_t>(std::min(fine.parent[i], fine.parent[j]));
      const auto b = static_cast<std::size_t>(std::max(fine.parent[i], fine.parent[j]));
      if (a == b) continue;
      const auto begin = coarse.links.column.begin() + coarse.links.start[a];
      const auto end = coarse.links.column.begin() + coarse.links.start[a + 1];
      fine.coarse[at] = static_cast<int>(std::lower_bound(begin, end, static_cast<int>(b)) -
                                         coarse.links.column.begin());
      const double near = (nodes.position[i] - nodes.position[j]).norm();
      const double far = (coarse_nodes.position[a] - coarse_nodes.position[b]).norm();
      fine.share[at] = std::clamp(near / std::max(far, 1e-300), least_share, most_share);
    }
  }
  return coarse;
}

}  // namespace

Hierarchy::Hierarchy(const Equations& equations, const Polygrid& grid) {
  level_.push_back({equations.links(), {}, {}, {}});
  Nodes nodes{equations.place(), grid.corner, std::vector<double>(equations.unknowns(), 1.0)};
  while (level_.back().links.rows() > most_coarsest) {
    GraphLevel& fine = level_.back();
    std::vector<int> parent = aggregates(fine, nodes.place);
    const auto count =
        static_cast<std::size_t>(*std::max_element(parent.begin(), parent.end())) + 1;
    // Pieces that touch nowhere do not grow together any more.
    if (count == parent.size() && nodes.place == std::vector<Vector3i>(count, nodes.place[0]))
      break;
    fine.parent = std::move(parent);
    Nodes coarse_nodes = coarser_nodes(nodes, fine.parent, count);
    GraphLevel coarse = coarser_level(fine, count, nodes, coarse_nodes);
    nodes = std::move(coarse_nodes);
    level_.push_back(std::move(coarse));
  }
}

std::vector<GraphValues> Hierarchy::values(const MediumValues& medium) const {
  std::vector<GraphValues> result(level_.size());
  std::vector<double> leak = medium.leak;
  result[0].link = medium.link;
  for (std::size_t l = 0; l < level_.size(); ++l) {
    const GraphLevel& level = level_[l];
    GraphValues& mine = result[l];
    mine.diagonal = leak;
    for (std::size_t i = 0; i < leak.size(); ++i) {
      for (int k = level.links.start[i]; k < level.links.start[i + 1]; ++k) {
        const auto at = static_cast<std::size_t>(k);
        mine.diagonal[i] += mine.link[at];
        mine.diagonal[static_cast<std::size_t>(level.links.column[at])] += mine.link[at];
      }
    }
    if (l + 1 == level_.size()) break;
    result[l + 1].link.assign(level_[l + 1].links.column.size(), 0.0);
    for (std::size_t k = 0; k < mine.link.size(); ++k) {
      if (level.coarse[k] < 0) continue;
      result[l + 1].link[static_cast<std::size_t>(level.coarse[k])] +=
          level.share[k] * mine.link[k];
    }
    std::vector<double> coarse(level_[l + 1].links.rows(), 0.0);
    for (std::size_t i = 0; i < leak.size(); ++i) {
      coarse[static_cast<std::size_t>(level.parent[i])] += leak[i];
    }
    leak = std::move(coarse);
  }
  return result;
}

ChannelLevels::ChannelLevels(const Hierarchy& hierarchy, const MediumValues& medium)
    : graph(hierarchy.values(medium)) {
  for (const GraphValues& level : graph) {
    inverse_diagonal.push_back(level.diagonal);
    for (double& d : inverse_diagonal.back()) d = 1.0 / d;
  }
  const Pattern& links = hierarchy.level().back().links;
  const auto rows = static_cast<Eigen::Index>(links.rows());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto row = static_cast<std::size_t>(i);
    matrix(i, i) = graph.back().diagonal[row];
    for (int k = links.start[row]; k < links.start[row + 1]; ++k) {
      const auto j = static_cast<Eigen::Index>(links.column[static_cast<std::size_t>(k)]);
      matrix(i, j) = matrix(j, i) = -graph.back().link[static_cast<std::size_t>(k)];
    }
  }
  const Eigen::MatrixXd inverse = inverse_definite(matrix);
  coarsest.assign(inverse.data(), inverse.data() + inverse.size());
}

}  // namespace kappamu::forward::polygrid
