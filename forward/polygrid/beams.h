// First collisions of collimated beams in the cells of a polygrid: refracted into the object
// (light_entry.h), marched in steps shorter than a cell to the surface that they meet next.
#pragma once

#include <span>
#include <vector>

#include "forward/object_model.h"
#include "forward/polygrid/surface_map.h"

namespace kappamu::forward::polygrid {

/// Adds ∫ S N dV of a light's beams to `load` [corner]; S = σs'/σt' of the power that collides in a
/// step, at the mean place of its collisions, whose functions share it: sums are exact. When no
/// more than `remainder` of a beam is left, the rest collides there. Powers after Fresnel go to
/// `balance`. Throws InputError where a beam meets the surface from inside.
void add_beams(const Polygrid& grid, const SurfaceMap& map, const ObjectProblem& problem,
               const ObjectLight& light, std::span<const Coefficients> of_cell, double remainder,
               std::vector<double>& load, ObjectBalance& balance);

}  // namespace kappamu::forward::polygrid
