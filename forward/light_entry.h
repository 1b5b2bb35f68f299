// How light enters an object: what every diffusion model of objects shares.
#pragma once

#include "core/optics.h"
#include "forward/object_model.h"

namespace kappamu::forward {

/// Of diffuse light from outside, the share that enters: η² (1 − R_φ), by reciprocity.
double diffuse_transmittance(const BoundaryConstants& constants);

/// Throws InputError unless mesh, medium, lights and tolerance are what a diffusion model can
/// answer. Whether the mesh is closed is not looked at.
void check_problem(const ObjectProblem& problem, const ObjectOptions& options);

}  // namespace kappamu::forward
