// Meshes and rays for the tests of forward/embedded.
#pragma once

#include <memory>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/ray_caster.h"

namespace kappamu::forward::embedded {

/// An icosahedron split `splits` times, vertices on the sphere, blown up to the sphere's volume.
TriangleMesh icosphere(double radius, int splits, const Eigen::Vector3d& centre);
/// A box from the origin, every face `cells` × `cells` squares of two triangles.
TriangleMesh box(const Eigen::Vector3d& size, int cells);
TriangleMesh transformed(TriangleMesh mesh, const Eigen::Affine3d& by);
/// Several components as one mesh; `inside_out` turns the second into a void.
TriangleMesh joined(TriangleMesh one, const TriangleMesh& other, bool inside_out = false);

/// Rays against a tree of boxes.
std::unique_ptr<RayCaster> make_caster(const TriangleMesh& mesh);

}  // namespace kappamu::forward::embedded
