#include "forward/polygrid/shape/place_nodes.h"

#include <algorithm>
#include <cstddef>

#include "forward/polygrid/cell_geometry.h"

namespace kappamu::forward {

using Eigen::Vector3d;

double boundary_spacing(const Polygrid& grid) {
  double sum = 0.0;
  std::size_t pairs = 0;
  for (std::size_t k = 0; k < grid.boundary_cell.size(); ++k) {
    for (const int next : grid.link[static_cast<std::size_t>(grid.boundary_cell[k])]) {
      if (next < 0) continue;
      for (const int other : grid.link[static_cast<std::size_t>(next)]) {
        if (other >= 0) continue;
        sum +=
            (grid.boundary_node[static_cast<std::size_t>(~other)] - grid.boundary_node[k]).norm();
        ++pairs;
      }
    }
  }
  return pairs == 0 ? 0.0 : sum / static_cast<double>(pairs);
}

void place_nodes(Polygrid& grid, const ClosestPoint& surface, double first_layer) {
  grid.node.resize(grid.cell.size());
  for (std::size_t i = 0; i < grid.cell.size(); ++i) {
    grid.node[i] = within_cell(grid, i, Vector3d::Constant(0.5));
  }
  const std::size_t boundary = grid.boundary_cell.size();
  grid.boundary_node.resize(boundary);
  grid.normal.resize(boundary);
  grid.area.resize(boundary);
  int near = 0;
  for (std::size_t k = 0; k < boundary; ++k) {
    const auto cell = static_cast<std::size_t>(grid.boundary_cell[k]);
    const auto found = surface.from(side_centre(grid, cell, grid.boundary_side[k]), near);
    near = found.triangle;
    grid.boundary_node[k] = found.point;
    grid.normal[k] = surface.normal(found.triangle);
    grid.area[k] = side_area(grid, cell, grid.boundary_side[k]).norm();
  }
  const double depth = first_layer * boundary_spacing(grid);
  if (!(depth > 0.0)) return;
  for (std::size_t k = 0; k < boundary; ++k) {
    const auto cell = static_cast<std::size_t>(grid.boundary_cell[k]);
    // Where the normal leaves the cell before that depth, on the way to the cell's middle instead.
    const Vector3d inwards = grid.boundary_node[k] - depth * grid.normal[k];
    const Vector3d to_middle = grid.node[cell] - grid.boundary_node[k];
    grid.node[cell] =
        place_in_cell(grid, cell, inwards)
            ? inwards
            : grid.boundary_node[k] + std::min(1.0, depth / to_middle.norm()) * to_middle;
  }
}

}  // namespace kappamu::forward
