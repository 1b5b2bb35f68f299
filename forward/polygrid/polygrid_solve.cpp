#include "forward/polygrid/polygrid_solve.h"

#include <algorithm>

#include "core/error.h"
#include "core/mesh/surface_norm.h"
#include "core/optics.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/light/reentry.h"
#include "forward/light_entry.h"
#include "forward/polygrid/polygrid_diffusion.h"
#include "forward/polygrid/split_polygrid.h"

namespace kappamu::forward {

namespace {

using namespace polygrid;

/// Half the cells' size takes away this many times the error that is left: three at order two, less
/// where the map bends an edge of the polycube flat and at edges of light; one where coefficients
/// jump within cells.
constexpr double difference_per_error = 1.5, difference_per_error_at_jumps = 1.0;
/// Memory that a cell takes, and of every channel and light that is solved for [bytes].
constexpr double bytes_per_cell = 1800.0, bytes_per_channel = 900.0, bytes_per_light = 100.0;
constexpr double usable_memory = 0.7;

double most_cells(std::span<const ObjectProblem> problems, const ObjectOptions& options) {
  if (options.max_elements) return static_cast<double>(*options.max_elements);
  double bytes = bytes_per_cell;
  for (const ObjectProblem& problem : problems) {
    bytes += bytes_per_channel + bytes_per_light * static_cast<double>(problem.lights.size());
  }
  return usable_memory * main_memory() / bytes;
}

struct Resolution {
  std::vector<PolygridAnswer> channel;
  std::size_t cells = 0;
  CgReport report;
  double solving = 0.0;      ///< seconds
  std::vector<double> gaps;  ///< as SurfaceMap has them
};

Resolution solved(const Polygrid& grid, std::span<const ObjectProblem> problems,
                  const std::string& device) {
  Resolution result;
  result.cells = grid.cell.size();
  PolygridDiffusion diffusion(grid, problems[0].mesh, problems[0].surface, problems[0].eta, device);
  std::vector<const ObjectMedium*> media;
  for (const ObjectProblem& problem : problems) media.push_back(&problem.medium);
  diffusion.set_media(media);
  const Stopwatch watch;
  result.channel = diffusion.solve(problems, {});
  result.solving = watch.seconds();
  result.report = diffusion.report();
  result.gaps = diffusion.surface_map().gaps();
  return result;
}

/// Sets the results' estimates.
double worst_error(std::span<const ObjectProblem> problems, std::span<const double> gaps,
                   const Resolution& coarse, const Resolution& fine,
                   std::vector<ObjectResult>& results) {
  double worst = 0.0;
  for (std::size_t c = 0; c < problems.size(); ++c) {
    results[c].error_estimate =
        polygrid_errors(problems[c], gaps, coarse.channel[c].exitance, fine.channel[c].exitance);
    for (const double error : results[c].error_estimate) worst = std::max(worst, error);
  }
  return worst;
}

std::string conclusion(bool solved, bool resolved, bool within, std::size_t cells, double worst) {
  if (!solved) return "the linear solver stopped before its tolerance";
  if (within) return formatted("the estimated error %g is within the tolerance", worst);
  if (resolved) {
    return formatted(
        "parts of the surface lie outside of the polygrid, with an estimated error of "
        "%g; model embedded has no such gaps",
        worst);
  }
  return formatted("stopped at %zu cells, the most allowed, with an estimated error of %g", cells,
                   worst);
}

std::vector<ObjectResult> solve_once(Polygrid grid, std::span<const ObjectProblem> problems,
                                     const ObjectOptions& options, Progress& progress) {
  const Stopwatch watch;
  const double most = most_cells(problems, options);
  if (8.0 * static_cast<double>(grid.cell.size()) > most) {
    throw InputError(
        "the polygrid has " + std::to_string(8 * grid.cell.size()) +
        " cells with its error's estimate, more than " +
        (options.max_elements ? "max_elements allows; raise it" : "fit this machine's memory"));
  }
  std::vector<ObjectResult> results(problems.size());
  Resolution fine = solved(grid, problems, options.device);
  double solving = fine.solving, worst = 0.0;
  bool resolved = false;
  while (!resolved && 8.0 * static_cast<double>(grid.cell.size()) <= most) {
    const Resolution coarse = std::move(fine);
    grid = split(grid, problems[0].mesh);
    fine = solved(grid, problems, options.device);
    solving += fine.solving;
    resolved = worst_error(problems, {}, coarse, fine, results) <= options.tolerance;
    worst = worst_error(problems, fine.gaps, coarse, fine, results);
    progress.update("polygrid", std::min(1.0, options.tolerance / std::max(worst, 1e-300)),
                    formatted("%zu cells, error %g", fine.cells, worst));
  }
  const double spent = watch.seconds();
  for (std::size_t c = 0; c < problems.size(); ++c) {
    ObjectResult& result = results[c];
    result.exitance = std::move(fine.channel[c].exitance);
    result.balance = std::move(fine.channel[c].balance);
    result.leaving = std::move(fine.channel[c].leaving);
    result.elements = fine.cells;
    result.iterations = fine.report.iterations;
    result.seconds = solving;
    result.setup_seconds = spent - solving;
    result.converged = fine.report.converged && worst <= options.tolerance;
    result.message =
        conclusion(fine.report.converged, resolved, worst <= options.tolerance, fine.cells, worst);
    if (!result.converged) result.warnings.push_back(result.message);
  }
  return results;
}

}  // namespace

std::vector<double> polygrid_errors(const ObjectProblem& problem, std::span<const double> gaps,
                                    std::span<const double> coarse, std::span<const double> fine) {
  const std::size_t samples = problem.surface.size();
  const double per_error =
      problem.medium.homogeneous() ? difference_per_error : difference_per_error_at_jumps;
  const double A = boundary_constants(problem.eta).A;
  std::vector<double> errors, missed(samples, 0.0);
  for (std::size_t l = 0; l < problem.lights.size(); ++l) {
    const auto mine = fine.subspan(l * samples, samples);
    const double size = surface_norm(problem.surface, mine);
    const double difference =
        surface_difference(problem.surface, mine, coarse.subspan(l * samples, samples));
    for (std::size_t t = 0; t < gaps.size(); ++t) {
      if (!(gaps[t] > 0.0)) continue;
      const double length = 2.0 * A * problem.medium.at(problem.surface.position[t]).kappa;
      missed[t] = mine[t] * std::min(1.0, gaps[t] / length);
    }
    const double error = difference / per_error + surface_norm(problem.surface, missed);
    errors.push_back(size > 0.0 ? error / size : 0.0);
  }
  return errors;
}

std::vector<ObjectResult> solve_on_polygrid(Polygrid grid, std::span<const ObjectProblem> problems,
                                            const ObjectOptions& options, Progress& progress) {
  for (const ObjectProblem& problem : problems) check_problem(problem, options);
  if (problems.empty()) return {};
  return with_reentry(problems, options,
                      [&](std::span<const ObjectProblem> asked, const ObjectOptions& how) {
                        return solve_once(grid, asked, how, progress);
                      });
}

}  // namespace kappamu::forward
