// `kappamu-studies objects`: error, time and elements of every model of objects on the same scenes,
// against Monte Carlo and, where there is one, the closed form of diffusion.
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

/// Seconds of every model against triangles and elements.
void measure_costs(const Request& request, Progress& progress, const Save& save);
/// Model `auto` on scenes that its table was not made from.
void measure_auto(const Request& request, Progress& progress, const Save& save);
/// Time against error of diffusion on cubes refined where the light asks for it, beside even cubes.
void measure_refinement(const Request& request, Progress& progress, const Save& save);
/// The error that diffusion on cubes states of its numerics beside the true one.
void measure_estimates(const Request& request, Progress& progress, const Save& save);
/// What tessellation and scale change of an answer.
void measure_invariance(const Request& request, Progress& progress, const Save& save);
/// Seconds from a scene's mesh file to its picture.
void measure_pictures(const Request& request, Progress& progress, const Save& save);

/// Closed form: exitance of a sphere in even diffuse light of irradiance 1 by diffusion, φ ∝
/// sinh(r √(μ/κ))/r.
double exitance_of_lit_sphere(double radius_mm, double kappa_mm, double mu_per_mm, double eta);

}  // namespace kappamu::studies
