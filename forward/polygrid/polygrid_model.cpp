#include "forward/polygrid/polygrid_model.h"

#include "core/processor_time.h"
#include "forward/light_entry.h"
#include "forward/polygrid/live_polygrid.h"
#include "forward/polygrid/polygrid_solve.h"
#include "forward/polygrid/shape/make_polygrid.h"

namespace kappamu::forward {

std::vector<ObjectResult> PolygridModel::solve_channels(std::span<const ObjectProblem> problems,
                                                        const ObjectOptions& options,
                                                        Progress& progress) {
  for (const ObjectProblem& problem : problems) check_problem(problem, options);
  if (problems.empty()) return {};
  const Stopwatch watch;
  PolygridOptions asked;
  asked.cells = first_cells;
  asked.drawn = problems[0].polycube;
  MadePolygrid made = make_polygrid(problems[0].mesh, asked, progress);
  const double making = watch.seconds();
  std::vector<ObjectResult> results =
      solve_on_polygrid(std::move(made.grid), problems, options, progress);
  for (ObjectResult& result : results) {
    result.setup_seconds += making;
    result.warnings.insert(result.warnings.end(), made.warnings.begin(), made.warnings.end());
  }
  return results;
}

std::unique_ptr<LiveModel> PolygridModel::keep(const LiveBody& object,
                                               const ObjectOptions& options) {
  return std::make_unique<LivePolygrid>(object, options.device);
}

ModelDescription polygrid_model() {
  return {.name = "polygrid",
          .text = "Diffusion on the cells of a polycube deformed to the object.",
          .limits =
              "Needs a polycube, which thin parts and several surfaces do not have; diffusion "
              "errs as with embedded.",
          .can = {.heterogeneous = true, .live = true, .reentry = true},
          .make = [] { return std::make_unique<PolygridModel>(); },
          .errs_by = &measured("embedded").error};
}

}  // namespace kappamu::forward
