#include "studies/polygrid/relaxation.h"

#include <deque>

namespace kappamu::studies {

namespace {

/// Breadth first from the boundary.
std::vector<int> depths(const NodeGrid& grid) {
  std::vector<int> depth(grid.node.size(), 0);
  std::deque<int> queue;
  for (const int node : grid.boundary_cell) {
    if (depth[static_cast<std::size_t>(node)] == 0) queue.push_back(node);
    depth[static_cast<std::size_t>(node)] = 1;
  }
  while (!queue.empty()) {
    const auto node = static_cast<std::size_t>(queue.front());
    queue.pop_front();
    for (const int link : grid.link[node]) {
      if (link < 0 || depth[static_cast<std::size_t>(link)] != 0) continue;
      depth[static_cast<std::size_t>(link)] = depth[node] + 1;
      queue.push_back(link);
    }
  }
  return depth;
}

template <class T, class Add, class Scale>
std::vector<T> means(const std::vector<T>& of_children, const std::vector<int>& parent,
                     std::size_t parents, const Add& add, const Scale& scale) {
  std::vector<T> result(parents);
  std::vector<double> count(parents, 0.0);
  for (std::size_t k = 0; k < of_children.size(); ++k) {
    add(result[static_cast<std::size_t>(parent[k])], of_children[k]);
    count[static_cast<std::size_t>(parent[k])] += 1.0;
  }
  for (std::size_t p = 0; p < parents; ++p) scale(result[p], 1.0 / count[p]);
  return result;
}

}  // namespace

std::vector<RelaxationLevel> relaxation_levels(const Polygrid& grid,
                                               std::span<const Coefficients> of_cell,
                                               std::span<const double> q, int levels) {
  std::vector<RelaxationLevel> result(1);
  result[0].grid = node_grid(grid);
  result[0].of_node.assign(of_cell.begin(), of_cell.end());
  result[0].q.assign(q.begin(), q.end());
  for (int l = 1; l < levels; ++l) {
    RelaxationLevel& fine = result.back();
    RelaxationLevel coarse;
    coarse.grid = coarser(fine.grid);
    coarse.of_node = means(
        fine.of_node, fine.grid.parent, coarse.grid.node.size(),
        [](Coefficients& a, const Coefficients& b) {
          a.kappa += b.kappa;
          a.mu += b.mu;
        },
        [](Coefficients& a, double by) {
          a.kappa *= by;
          a.mu *= by;
        });
    coarse.q = means(
        fine.q, fine.grid.boundary_parent, coarse.grid.boundary_node.size(),
        [](double& a, double b) { a += b; }, [](double& a, double by) { a *= by; });
    result.push_back(std::move(coarse));
  }
  for (RelaxationLevel& level : result) {
    level.weights = laplacian_weights(level.grid);
    level.depth = depths(level.grid);
  }
  return result;
}

void relax(const RelaxationLevel& level, double A, int steps, int depth, NodeFluence& fluence,
           const std::function<void(std::size_t processed)>& after) {
  const NodeGrid& grid = level.grid;
  const auto kappa = [&](std::size_t node) { return level.of_node[node].kappa; };
  for (int step = 0; step < steps; ++step) {
    const NodeFluence before = fluence;
    std::size_t processed = grid.boundary_node.size();
    for (std::size_t k = 0; k < grid.node.size(); ++k) {
      if (depth > 0 && level.depth[k] > depth) continue;
      double flow = 0.0, weights = 0.0;
      for (std::size_t s = 0; s < 6; ++s) {
        const int link = grid.link[k][s];
        const double w = level.weights.weight[k][s];
        // κ of a boundary node is that of its interior node.
        flow += w * (link >= 0 ? kappa(static_cast<std::size_t>(link)) *
                                     before.node[static_cast<std::size_t>(link)]
                               : kappa(k) * before.boundary[static_cast<std::size_t>(~link)]);
        weights += w;
      }
      fluence.node[k] = flow / (level.of_node[k].mu / kappa(k) + weights) / kappa(k);
      ++processed;
    }
    for (std::size_t b = 0; b < grid.boundary_node.size(); ++b) {
      const auto node = static_cast<std::size_t>(grid.boundary_cell[b]);
      const double distance = (grid.boundary_node[b] - grid.node[node]).norm();
      const double robin = 2.0 * A * kappa(node);
      fluence.boundary[b] =
          (level.q[b] * distance + robin * before.node[node]) / (distance + robin);
    }
    if (after) after(processed);
  }
}

NodeFluence from_coarser(const RelaxationLevel& fine, const NodeFluence& coarse) {
  NodeFluence result;
  for (const int parent : fine.grid.parent) {
    result.node.push_back(coarse.node[static_cast<std::size_t>(parent)]);
  }
  for (const int parent : fine.grid.boundary_parent) {
    result.boundary.push_back(coarse.boundary[static_cast<std::size_t>(parent)]);
  }
  return result;
}

}  // namespace kappamu::studies
