// An object's cut cells as a DiffusionOperator, so that a fit works on objects as on blocks. Every
// cube of a uniform octree about the object is a voxel of the medium: κ and μ are constant in it,
// the fluence is trilinear (equations/element.h). A is linear in κ and μ, so that gradients are
// exact.
//
// Light is even (SourceModel::boundary): one irradiance per triangle and pattern. Exitance is one
// value per triangle.
#pragma once

#include <memory>

#include "core/mesh/triangle_mesh.h"
#include "core/ray_caster.h"
#include "forward/operator.h"

namespace kappamu::forward::embedded {

/// Of the closed `mesh`, whose rays are `rays`. make() takes 2^n voxels along each edge of the root
/// cube and throws InputError for other shapes, for a collimated beam, whose load depends on κ in a
/// way that has no derivative here, and for [W]'s convention. It reads neither faces nor sides.
std::shared_ptr<const OperatorFactory> object_operators(const TriangleMesh& mesh,
                                                        std::shared_ptr<const RayCaster> rays);

/// The root cube about `mesh` as 2^level voxels along each edge.
GridShape voxels_about(const TriangleMesh& mesh, int level);

}  // namespace kappamu::forward::embedded
