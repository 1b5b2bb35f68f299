// How light enters an object: what every diffusion model of objects shares.
#pragma once

#include "core/optics.h"
#include "forward/object_model.h"

namespace kappamu::forward {

/// A beam inside the object, up to the surface it meets next.
struct BeamPath {
  Eigen::Vector3d from, direction;  ///< [mm]; refracted, of unit length
  double length = 0.0;              ///< [mm]; 0 where the ray slipped out along an edge of the mesh
  double power = 0.0;               ///< after Fresnel reflection [mm²]
  std::optional<int> meets;         ///< the triangle at its end
};

/// By Snell's and Fresnel's laws. `size` is the object's [mm]. Throws InputError where the beam
/// meets the surface from inside.
BeamPath enter(const ObjectProblem& problem, const Beam& beam, double size);

/// Of diffuse light from outside, the share that enters: η² (1 − R_φ), by reciprocity.
double diffuse_transmittance(const BoundaryConstants& constants);

/// Throws InputError unless mesh, medium, lights and tolerance are what a diffusion model can
/// answer. Whether the mesh is closed is not looked at.
void check_problem(const ObjectProblem& problem, const ObjectOptions& options);

}  // namespace kappamu::forward
