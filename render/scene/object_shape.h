// The mesh that a scene's object states, in the object's frame: its box is centred at the origin.
#pragma once

#include "core/mesh/triangle_mesh.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// Reads or makes the mesh, gives it its size, and splits triangles with edges above 1/64 of it,
/// so that light is resolved on large flat faces. What was mended goes to `warnings`. Throws
/// InputError naming the object.
TriangleMesh make_object_mesh(const SceneObject& object, std::vector<std::string>& warnings);

/// Of a shape turned about x, then y, then z.
Eigen::Matrix3d turn_matrix(const Eigen::Vector3d& degrees);

}  // namespace kappamu::render
