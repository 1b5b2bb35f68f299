#include "forward/block/block_model.h"

#include <algorithm>

#include "core/error.h"
#include "core/mesh/surface_norm.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/block/block_diffusion.h"
#include "forward/block/live_block.h"
#include "forward/light_entry.h"

namespace kappamu::forward {

namespace {

using namespace block;

/// As `embedded` has them (forward/embedded/body_solve.cpp): where coefficients jump the error
/// falls with h, else with h² but for the edges of light.
constexpr double difference_per_error = 2.0, difference_per_error_at_jumps = 1.0;
/// Memory that a voxel takes, and of every light that is solved for [bytes].
constexpr double bytes_per_voxel = 200.0, bytes_per_light = 60.0;
constexpr double usable_memory = 0.7;

BlockAnswer solved(const ObjectProblem& problem, const BlockGrid& grid,
                   const ObjectOptions& options, std::vector<std::string>& warnings) {
  const FaceMap map(grid, problem.mesh, problem.surface);
  BlockDiffusion diffusion(grid, map, problem.eta, options.device);
  if (!diffusion.warning().empty()) warnings = {diffusion.warning()};
  diffusion.set_medium(problem.medium);
  return diffusion.solve(problem, {});
}

}  // namespace

std::vector<double> block_errors(const ObjectProblem& problem, std::span<const double> coarse,
                                 std::span<const double> fine) {
  const std::size_t samples = problem.surface.size();
  const double per_error =
      problem.medium.homogeneous() ? difference_per_error : difference_per_error_at_jumps;
  std::vector<double> errors;
  for (std::size_t l = 0; l < problem.lights.size(); ++l) {
    const auto mine = [&](std::span<const double> exitance) {
      return exitance.subspan(l * samples, samples);
    };
    const double size = surface_norm(problem.surface, mine(fine));
    const double difference = surface_difference(problem.surface, mine(fine), mine(coarse));
    errors.push_back(size > 0.0 ? difference / per_error / size : 0.0);
  }
  return errors;
}

ObjectResult BlockModel::solve(const ObjectProblem& problem, const ObjectOptions& options,
                               Progress& progress) {
  const Stopwatch watch;
  check_problem(problem, options);
  const BlockGrid grid = require_block_grid(problem.mesh, problem.medium);
  const double bytes =
      bytes_per_voxel + bytes_per_light * static_cast<double>(problem.lights.size());
  const double most = options.max_elements ? static_cast<double>(*options.max_elements)
                                           : usable_memory * main_memory() / bytes;
  ObjectResult result;
  BlockAnswer fine;
  double worst = 0.0;
  for (int factor = 1;; factor *= 2) {
    const BlockGrid finer = grid.refined(factor);
    if (static_cast<double>(finer.shape.cells()) > most) {
      if (factor <= 2) {
        throw InputError(
            "the block has " + std::to_string(finer.shape.cells()) +
            " voxels with its error's estimate, more than " +
            (options.max_elements ? "max_elements allows; raise it" : "fit this machine's memory"));
      }
      break;
    }
    BlockAnswer coarse = std::move(fine);
    fine = solved(problem, finer, options, result.warnings);
    result.elements = finer.shape.cells();
    result.iterations = fine.report.iterations;
    result.seconds += fine.report.seconds;
    if (factor == 1) continue;
    result.error_estimate = block_errors(problem, coarse.exitance, fine.exitance);
    worst = 0.0;
    for (const double error : result.error_estimate) worst = std::max(worst, error);
    progress.update("grid", std::min(1.0, options.tolerance / std::max(worst, 1e-300)),
                    formatted("%zu voxels, error %g", result.elements, worst));
    if (worst <= options.tolerance) break;
  }
  const bool solved_well = fine.report.termination == Termination::converged;
  result.converged = solved_well && worst <= options.tolerance;
  result.message = !solved_well ? fine.report.message
                   : result.converged
                       ? formatted("the estimated error %g is within the tolerance", worst)
                       : formatted(
                             "stopped at %zu voxels, the most allowed, with an estimated "
                             "error of %g",
                             result.elements, worst);
  if (!result.converged) result.warnings.push_back(result.message);
  result.exitance = std::move(fine.exitance);
  result.balance = std::move(fine.balance);
  result.setup_seconds = watch.seconds() - result.seconds;
  return result;
}

std::unique_ptr<LiveModel> BlockModel::keep(const LiveBody& object, const ObjectOptions& options,
                                            Progress& /*progress*/) {
  return std::make_unique<LiveBlock>(object, options.device);
}

ModelDescription block_model() {
  return {.name = "grid",
          .text = "Diffusion on the voxels of a box, halved until two resolutions agree.",
          .limits = "Only boxes of whole voxels along the axes; diffusion errs as with embedded.",
          .can = {.heterogeneous = true, .any_shape = false, .inner_light = true, .live = true},
          .make = [] { return std::make_unique<BlockModel>(); },
          .measured = &measured("grid"),
          .errs_by = &measured("embedded").error};
}

}  // namespace kappamu::forward
