// What the errors and costs of models of objects depend on: a few numbers of shape and medium.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward {

/// All but `triangles` are dimensionless; lengths are in mean free paths 3κ.
struct ObjectFeatures {
  double size = 0.0;       ///< longest edge of the box
  double thickness = 0.0;  ///< 2V/S: the thickness of a slab, two thirds of a sphere's radius
  double albedo = 1.0;     ///< σs'/(σs' + μ)
  /// Length of edges sharper than 40°, times a mean free path, over S; at most 3 over `size`, as a
  /// flat box has: creases of a rough mesh are no such edges.
  double edges = 0.0;
  std::size_t patches = 0;  ///< of the answer, over which noise is stated: forward/patches.h
  double contrast = 1.0;    ///< largest over smallest κ or μ, the greater; 1: homogeneous
  bool block = false;       ///< a box of whole voxels, as the model `grid` needs
  double diffuse = 0.0;     ///< share of the irradiance that is diffuse
  double slant = 0.0;       ///< of beams: 1 less the cosine at which they meet the surface, mean
  std::size_t triangles = 0;
};

/// The slab that an object is compared with.
struct EquivalentSlab {
  double thickness = 0.0;       ///< 2V/S [mean free paths]
  double albedo = 1.0;          ///< σs'/(σs' + μ)
  double mean_free_path = 0.0;  ///< 3κ [mm]
};
EquivalentSlab equivalent_slab(const ObjectProblem& problem);

/// Of a medium that varies: κ the harmonic mean and μ the mean, over points of a lattice in the
/// object's box.
/// `light`: of that one alone; none: of all together.
ObjectFeatures features_of(const ObjectProblem& problem,
                           std::optional<std::size_t> light = std::nullopt);

}  // namespace kappamu::forward
