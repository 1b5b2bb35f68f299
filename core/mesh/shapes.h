// Procedural closed meshes, oriented outwards, centred at the origin. Edges are about the longest
// extent over `tessellation` long; doubling it halves them.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

/// `size`: edges along the axes; all lengths in mm.
TriangleMesh box_mesh(const Eigen::Vector3d& size, int tessellation);
TriangleMesh sphere_mesh(double radius, int tessellation);
/// About the z axis.
TriangleMesh cylinder_mesh(double radius, double height, int tessellation);
/// A tube of `minor` radius along a circle of `major` radius about the z axis.
TriangleMesh torus_mesh(double major, double minor, int tessellation);
/// A cone about the z axis, its tip up; its box is centred at the origin.
TriangleMesh cone_mesh(double radius, double height, int tessellation);
/// A fluted column about the z axis with a round bore from its top, deep enough for a light.
TriangleMesh candle_mesh(double radius, double height, int tessellation);

TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& by);
/// Inside out: what was a body becomes a void.
TriangleMesh turned_inside_out(TriangleMesh mesh);
/// Both, as separate components.
TriangleMesh joined(TriangleMesh one, const TriangleMesh& other);

/// Scales and moves so that the box's longest edge is `size_mm` and its centre the origin. Throws
/// InputError unless `size_mm` is positive and finite.
TriangleMesh fitted(TriangleMesh mesh, double size_mm);

/// A shape known by name. Its proportion is one number between 0 and 1.
struct NamedShape {
  std::string_view name;
  std::string_view proportion;  ///< what the number means; empty: the shape has none
  double usual = 0.0;           ///< the proportion where none is given
};
std::span<const NamedShape> named_shapes();

/// The shape, `size_mm` along the longest edge of its box. Throws InputError for an unknown name, a
/// proportion out of (0, 1), or a tessellation out of [1, 400].
TriangleMesh make_shape(std::string_view name, double size_mm, int tessellation,
                        std::optional<double> proportion = std::nullopt);

}  // namespace kappamu
