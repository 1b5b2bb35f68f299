#include "forward/polygrid/polygrid_model.h"

#include "core/processor_time.h"
#include "forward/light_entry.h"
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

}  // namespace kappamu::forward
