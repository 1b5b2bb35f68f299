#include "forward/embedded/discretisation.h"

namespace kappamu::forward::embedded {

namespace {

/// Reached only where slits narrower than a coarse cube hold the cycle up.
constexpr int most_iterations = 100;

}  // namespace

Discretisation::Discretisation(Octree octree, CutMesh cut, const ObjectMedium& medium, double A)
    : tree(std::move(octree)),
      mesh(std::move(cut)),
      coefficients(cube_coefficients(mesh, tree, medium)),
      hierarchy(make_hierarchy(mesh, cube_elements(mesh, coefficients, A))) {}

double diffuse_transmittance(const BoundaryConstants& constants) {
  return constants.eta * constants.eta * (1.0 - constants.r_phi);
}

Answer answer(const Discretisation& d, const ObjectProblem& problem,
              const BoundaryConstants& constants, double tolerance) {
  const std::size_t lights = problem.lights.size(), samples = problem.surface.size();
  const NodeSpace& space = d.hierarchy.space;
  Answer result;
  result.balance.resize(lights);
  std::vector<std::vector<double>> load(lights, std::vector<double>(space.unknowns(), 0.0));
  // What enters diffusely, E_t, and its share of the boundary condition's q = 4 E_t/(1 − R_φ).
  std::vector<std::vector<double>> entering(lights);
  for (std::size_t l = 0; l < lights; ++l) {
    const BeamPowers beams = add_beams(d.tree, d.mesh, space, d.coefficients, problem,
                                       problem.lights[l].beams, load[l]);
    ObjectBalance& balance = result.balance[l];
    balance.entering = beams.entering;
    balance.unscattered = beams.unscattered;
    balance.absorbed = beams.absorbed;
    if (problem.lights[l].diffuse.empty()) continue;
    entering[l] = problem.lights[l].diffuse;
    std::vector<double> flux(samples);
    for (std::size_t t = 0; t < samples; ++t) {
      entering[l][t] *= diffuse_transmittance(constants);
      flux[t] = 4.0 * entering[l][t] / (1.0 - constants.r_phi) / (2.0 * constants.A);
      balance.entering += entering[l][t] * problem.surface.area[t];
    }
    add_surface_load(d.mesh, space, flux, load[l]);
  }
  result.report = solve(d.hierarchy, load, result.fluence, tolerance, most_iterations);
  for (std::size_t l = 0; l < lights; ++l) {
    std::vector<double> exitance = triangle_means(d.mesh, space, result.fluence[l], samples);
    ObjectBalance& balance = result.balance[l];
    for (std::size_t t = 0; t < samples; ++t) {
      if (!entering[l].empty()) {
        exitance[t] -= 4.0 * entering[l][t] / (1.0 - constants.r_phi);
      }
      exitance[t] /= 2.0 * constants.A;
      if (!entering[l].empty()) exitance[t] += entering[l][t];
      balance.exiting += exitance[t] * problem.surface.area[t];
    }
    balance.absorbed += absorbed_power(d.mesh, space, d.coefficients, result.fluence[l]);
    result.exitance.push_back(std::move(exitance));
  }
  return result;
}

}  // namespace kappamu::forward::embedded
