#include "forward/polygrid/polygrid_model.h"

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/light_entry.h"
#include "forward/polygrid/live_polygrid.h"
#include "forward/polygrid/polygrid_solve.h"
#include "forward/polygrid/shape/make_polygrid.h"

namespace kappamu::forward {

Polygrid first_polygrid(int cells, const std::function<Polygrid(int)>& made) {
  constexpr int more_cells = 3, most_first_cells = 60'000;
  for (;; cells *= more_cells) {
    try {
      return made(cells);
    } catch (const InputError&) {
      if (more_cells * cells > most_first_cells) throw;
    }
  }
}

void PolygridModel::describe(const OptionVisitor& visit) {
  constexpr Bounds cells{.least = 100.0, .most = 2e6, .closed = true};
  visit({"first_cells", "Polygrid", "", "", cells,
         "Cells of the first polygrid; in the window that of moving lights"},
        &first_cells_);
}

std::vector<ObjectResult> PolygridModel::solve_channels(std::span<const ObjectProblem> problems,
                                                        const ObjectOptions& options,
                                                        Progress& progress) {
  for (const ObjectProblem& problem : problems) check_problem(problem, options);
  if (problems.empty()) return {};
  std::vector<std::string> warnings;  // of the polygrid made last
  const auto made = [&](int cells) {
    PolygridOptions asked;
    asked.cells = cells;
    asked.drawn = problems[0].polycube;
    MadePolygrid polygrid = make_polygrid(problems[0].mesh, asked, progress);
    warnings = std::move(polygrid.warnings);
    return std::move(polygrid.grid);
  };
  const Stopwatch watch;
  Polygrid first = first_polygrid(first_cells_, made);
  const double making = watch.seconds();
  const PolygridMaker finer = [&](int cells) -> std::optional<Polygrid> {
    try {
      return made(cells);
    } catch (const InputError&) {
      return std::nullopt;
    }
  };
  std::vector<ObjectResult> results =
      solve_on_polygrid(std::move(first), problems, options, progress, finer);
  for (ObjectResult& result : results) {
    result.setup_seconds += making;
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  }
  return results;
}

std::unique_ptr<LiveModel> PolygridModel::keep(const LiveBody& object, const ObjectOptions& options,
                                               Progress& progress) {
  return std::make_unique<LivePolygrid>(object, first_cells_, options, progress);
}

ModelDescription polygrid_model() {
  return {.name = "polygrid",
          .text = "Diffusion on the cells of a polycube deformed to the object.",
          .limits =
              "Needs a polycube, which thin parts and several surfaces do not have; diffusion "
              "errs as with embedded.",
          .can = {.heterogeneous = true, .inner_light = true, .live = true, .reentry = true},
          .make = [] { return std::make_unique<PolygridModel>(); },
          .errs_by = &measured("embedded").error};
}

}  // namespace kappamu::forward
