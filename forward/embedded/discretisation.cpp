#include "forward/embedded/discretisation.h"

#include <algorithm>

#include "core/mesh/surface_norm.h"
#include "core/parallel.h"
#include "forward/light_entry.h"

namespace kappamu::forward::embedded {

namespace {

/// Relative residuals that leave less than is asked for, measured.
double residual_for(double linear_tolerance) {
  return std::min(1e-5, 0.02 * linear_tolerance);
}

std::vector<std::vector<Coefficients>> coefficients_of(const CutMesh& mesh, const Octree& tree,
                                                       std::span<const ObjectMedium* const> media) {
  std::vector<std::vector<Coefficients>> result;
  for (const ObjectMedium* medium : media) {
    result.push_back(cube_coefficients(mesh, tree, *medium));
  }
  return result;
}

bool run_alike(const std::vector<Beam>& one, const std::vector<Beam>& other) {
  return std::equal(
      one.begin(), one.end(), other.begin(), other.end(), [](const Beam& a, const Beam& b) {
        return a.triangle == b.triangle && a.position == b.position && a.direction == b.direction;
      });
}

/// What enters diffusely, E_t, per triangle; empty where no diffuse light falls.
std::vector<double> entering(const ObjectLight& light, const BoundaryConstants& constants) {
  std::vector<double> result = light.diffuse;
  for (double& irradiance : result) irradiance *= diffuse_transmittance(constants);
  return result;
}

/// The light's share q of the boundary condition, from E_t.
double boundary_source(double entering, const BoundaryConstants& constants) {
  return entering * constants.q_per_entering();
}

/// Adds the light's beams to loads and balances; beams of several channels that share paths are
/// marched together.
void add_beam_loads(const Discretisation& d, const Channels& channels, std::span<Load> loads,
                    std::span<const std::size_t> light_of, Answers& result) {
  std::vector<char> done(loads.size(), 0);
  for (std::size_t first = 0; first < loads.size(); ++first) {
    if (done[first] != 0) continue;
    const auto paths = channels.paths[loads[first].channel][light_of[first]];
    std::vector<ChannelBeams> alike;
    for (std::size_t k = first; k < loads.size(); ++k) {
      const std::size_t c = loads[k].channel, l = light_of[k];
      if (channels.paths[c][l] != paths) continue;
      done[k] = 1;
      Answer& answer = result.channel[c];
      alike.push_back({&d.coefficients[c], &channels.problems[c].lights[l].beams, &loads[k].power,
                       &answer.balance[l], &answer.leaving[l]});
    }
    add_beams(d.tree, d.mesh, d.space(), *paths, alike);
  }
}

void add_diffuse_load(const Discretisation& d, const Channels& channels, const ObjectLight& from,
                      Load& load, ObjectBalance& balance) {
  if (from.diffuse.empty()) return;
  std::vector<double> flux = entering(from, channels.constants);
  for (std::size_t t = 0; t < flux.size(); ++t) {
    balance.entering += flux[t] * channels.problems[0].surface.area[t];
    flux[t] = boundary_source(flux[t], channels.constants) / (2.0 * channels.constants.A);
  }
  add_surface_load(d.mesh, d.space(), flux, load.power);
}

std::vector<double> exitance_of(const Discretisation& d, const ObjectProblem& problem,
                                const ObjectLight& light, const BoundaryConstants& constants,
                                const std::vector<double>& fluence) {
  std::vector<double> exitance = triangle_means(d.mesh, d.space(), fluence, problem.surface.size());
  const std::vector<double> inward = entering(light, constants);
  for (std::size_t t = 0; t < exitance.size(); ++t) {
    if (!inward.empty()) exitance[t] -= boundary_source(inward[t], constants);
    exitance[t] /= 2.0 * constants.A;
    if (!inward.empty()) exitance[t] += inward[t];
  }
  return exitance;
}

}  // namespace

Discretisation::Discretisation(Octree octree, CutMesh cut,
                               std::span<const ObjectMedium* const> media, double A)
    : tree(std::move(octree)),
      mesh(std::move(cut)),
      coefficients(coefficients_of(mesh, tree, media)),
      levels(make_levels(mesh.cubes, cube_elements(mesh, coefficients, A))) {}

Channels::Channels(std::span<const ObjectProblem> all)
    : problems(all.begin(), all.end()), constants(boundary_constants(all[0].eta)), walls(all[0]) {
  for (const ObjectProblem& problem : problems) {
    auto& mine = paths.emplace_back();
    for (std::size_t l = 0; l < problem.lights.size(); ++l) {
      const std::vector<Beam>& beams = problem.lights[l].beams;
      const bool known = l < problems[0].lights.size() && paths.size() > 1 &&
                         run_alike(beams, problems[0].lights[l].beams);
      mine.push_back(known ? paths[0][l] : std::make_shared<BeamPaths>(walls, beams));
    }
  }
}

std::vector<const ObjectMedium*> Channels::media() const {
  std::vector<const ObjectMedium*> result;
  for (const ObjectProblem& problem : problems) result.push_back(&problem.medium);
  return result;
}

std::size_t Channels::lights() const {
  std::size_t count = 0;
  for (const ObjectProblem& problem : problems) count += problem.lights.size();
  return count;
}

Answers answers(const Discretisation& d, const Channels& channels, LinearSolver& solver,
                double linear_tolerance) {
  Answers result;
  std::vector<Load> loads;
  std::vector<std::size_t> light_of;
  for (std::size_t c = 0; c < channels.problems.size(); ++c) {
    const std::vector<ObjectLight>& lights = channels.problems[c].lights;
    Answer& answer = result.channel.emplace_back();
    answer.balance.resize(lights.size());
    answer.leaving.resize(lights.size());
    for (std::size_t l = 0; l < lights.size(); ++l) {
      loads.push_back({c, std::vector<double>(d.space().unknowns(), 0.0)});
      light_of.push_back(l);
    }
    answer.fluence.resize(lights.size());
    answer.exitance.resize(lights.size());
    answer.coarser_exitance.resize(lights.size());
  }
  const auto for_loads = [&](const auto& work) {
    for_rows(static_cast<int>(loads.size()), [&](int row) {
      const auto k = static_cast<std::size_t>(row);
      work(k, channels.problems[loads[k].channel].lights[light_of[k]],
           result.channel[loads[k].channel]);
    });
  };
  for_loads([&](std::size_t k, const ObjectLight& light, Answer& answer) {
    add_diffuse_load(d, channels, light, loads[k], answer.balance[light_of[k]]);
  });
  add_beam_loads(d, channels, loads, light_of, result);
  std::vector<std::vector<double>> fluence(loads.size());
  CgEnd ends{residual_for(linear_tolerance)};
  if (d.levels.level.size() > 1) {
    const Transfer transfer(d.levels);
    std::vector<Load> restricted(loads.size());
    for_loads([&](std::size_t k, const ObjectLight&, Answer&) {
      restricted[k] = {loads[k].channel, transfer.restricted(loads[k].power)};
    });
    // On the fine level, of a coarse fluence; and how far the next solve goes. An error e of the
    // fluence is e/(2A) of the exitance, and ∫ e²/(2A) dA ≤ eᵀ A e.
    std::vector<std::vector<double>> exitance(loads.size());
    const auto exitance_and_end = [&](std::size_t k, const ObjectLight& light) {
      const ObjectProblem& problem = channels.problems[loads[k].channel];
      std::vector<double> prolonged = transfer.prolonged(fluence[k]);
      exitance[k] = exitance_of(d, problem, light, channels.constants, prolonged);
      const double left = linear_tolerance * surface_norm(problem.surface, exitance[k]);
      ends.energy[k] = 2.0 * channels.constants.A * left * left;
      return prolonged;
    };
    // One iteration is enough for the exitance's size.
    solver.solve(restricted, fluence, {ends.residual, 1}, 1);
    ends.energy.resize(loads.size());
    for_loads(
        [&](std::size_t k, const ObjectLight& light, Answer&) { exitance_and_end(k, light); });
    result.converged = solver.solve(restricted, fluence, ends, 1).converged;
    for_loads([&](std::size_t k, const ObjectLight& light, Answer& answer) {
      fluence[k] = exitance_and_end(k, light);
      answer.coarser_exitance[light_of[k]] = std::move(exitance[k]);
    });
  }
  const CgReport report = solver.solve(loads, fluence, ends);
  result.iterations = report.iterations;
  result.converged = result.converged && report.converged;
  for_loads([&](std::size_t k, const ObjectLight& light, Answer& answer) {
    const ObjectProblem& problem = channels.problems[loads[k].channel];
    std::vector<double> exitance = exitance_of(d, problem, light, channels.constants, fluence[k]);
    ObjectBalance& balance = answer.balance[light_of[k]];
    for (std::size_t t = 0; t < problem.surface.size(); ++t) {
      balance.exiting += exitance[t] * problem.surface.area[t];
    }
    balance.absorbed +=
        absorbed_power(d.mesh, d.space(), d.coefficients[loads[k].channel], fluence[k]);
    answer.exitance[light_of[k]] = std::move(exitance);
    answer.fluence[light_of[k]] = std::move(fluence[k]);
  });
  return result;
}

}  // namespace kappamu::forward::embedded
