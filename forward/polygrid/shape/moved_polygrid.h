// A polygrid that follows an object whose vertices move ([W] 5): its cells stay the same cells.
#pragma once

#include <optional>

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

/// Cells of the polygrid of `from`, an earlier shape of the same triangles, in the shape `to`.
/// Outer corners go with the point of the surface that they lie on, inner ones by the harmonic
/// extension of that over the cells' edges. Nothing where a cell comes out worse than a scaled
/// Jacobian of 0.1: such a shape needs a polygrid of its own. `first_layer` as in PolygridOptions.
std::optional<Polygrid> moved_polygrid(Polygrid grid, const TriangleMesh& from,
                                       const TriangleMesh& to, double first_layer);

}  // namespace kappamu::forward
