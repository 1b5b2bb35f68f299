// Positions of a polygrid's nodes, its corners being mapped.
#pragma once

#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

/// Mean distance of boundary nodes whose interior nodes are linked [mm].
double boundary_spacing(const Polygrid& grid);

/// Boundary nodes go to the surface point closest to the middle of their faces, with the surface's
/// normal there; interior nodes to the middle of their cells, those linked to a boundary node to
/// `first_layer` times boundary_spacing() along its inward normal (PolygridOptions). Sets the
/// areas.
void place_nodes(Polygrid& grid, const ClosestPoint& surface, double first_layer);

}  // namespace kappamu::forward
