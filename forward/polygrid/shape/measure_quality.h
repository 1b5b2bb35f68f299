// How good a polygrid is, in numbers (PolygridQuality).
#pragma once

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/shape/make_polygrid.h"

namespace kappamu::forward {

/// Everything but `refinement` and `cpu_seconds`.
PolygridQuality measure_quality(const Polygrid& grid, const TriangleMesh& mesh);

}  // namespace kappamu::forward
