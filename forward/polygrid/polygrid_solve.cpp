#include "forward/polygrid/polygrid_solve.h"

#include <algorithm>
#include <cmath>

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
/// No more bytes, nor more than the usable memory, unless max_elements is set.
constexpr double most_bytes = 4e9;
/// The order of the error between two edges of cells before it is measured, and within these after.
constexpr double assumed_order = 1.5, least_order = 0.5, greatest_order = 2.0;
/// Of the tolerance, what the next polygrid aims at; and times the cells before that it may have.
constexpr double aimed_at = 0.8, least_growth = 2.0, most_growth = 8.0;

struct Resolution {
  std::vector<PolygridAnswer> channel;
  std::size_t cells = 0;
  CgReport report;
  double solving = 0.0;      ///< seconds
  std::vector<double> gaps;  ///< as SurfaceMap has them
};

class PolygridSolve {
 public:
  PolygridSolve(std::span<const ObjectProblem> problems, const ObjectOptions& options,
                Progress& progress)
      : problems_(problems), options_(options), progress_(progress), results_(problems.size()) {
    for (const ObjectProblem& problem : problems) {
      bytes_each_ +=
          bytes_per_channel + bytes_per_light * static_cast<double>(problem.lights.size());
    }
    most_ = options.max_elements ? static_cast<double>(*options.max_elements)
                                 : std::min(usable_memory(), most_bytes) / bytes_each_;
  }

  /// `grid` is left as the coarser of the last two.
  std::vector<ObjectResult> run(Polygrid& grid, const PolygridMaker& maker) {
    if (8.0 * static_cast<double>(grid.cell.size()) > most_) {
      throw InputError("the polygrid has " + needs(8.0 * static_cast<double>(grid.cell.size())) +
                       " with its error's estimate, more than the " + allowed());
    }
    std::optional<Resolution> coarse;
    double order = assumed_order;
    for (bool measured = false;; measured = true) {
      if (!coarse) coarse = solved(grid);
      Polygrid halved = split(grid, problems_[0].mesh);
      Resolution fine = solved(halved);
      const double cells_before = cells_, error_before = worst_;
      estimate_errors(*coarse, fine);
      if (worst_ <= options_.tolerance || !fine.report.converged) break;
      if (measured) order = polygrid_order(cells_before, error_before, cells_, worst_);
      needed_ = polygrid_cells_needed(cells_, worst_, aimed_at * options_.tolerance, order);
      // An order that was measured is believed; before, a polygrid of half the bound measures it.
      if (needed_ > most_ && (measured || least_growth * cells_ > most_)) break;
      const double next =
          std::min(std::clamp(needed_, least_growth * cells_, most_growth * cells_),
                   needed_ > most_ ? std::max(0.5 * most_, least_growth * cells_) : most_);
      coarse.reset();
      auto made = maker ? maker(static_cast<int>(next / 8.0)) : std::nullopt;
      // As many as before say that a drawn polycube has no refinement in between.
      if (made && made->cell.size() > grid.cell.size() &&
          8.0 * static_cast<double>(made->cell.size()) <= most_) {
        grid = std::move(*made);
      } else if (8.0 * cells_ <= most_) {
        grid = std::move(halved);
        coarse = std::move(fine);
      } else {
        break;
      }
    }
    return finished();
  }

 private:
  std::string needs(double cells) const {
    return formatted("%.0f cells (%s)", cells, gigabytes(bytes_each_ * cells).c_str());
  }
  std::string allowed() const {
    return formatted("%.0f cells allowed; raise max_elements or take model embedded", most_);
  }

  Resolution solved(const Polygrid& grid) {
    const auto cells = static_cast<double>(grid.cell.size());
    progress_.update("polygrid", worst_ > 0.0 ? std::min(1.0, options_.tolerance / worst_) : 0.0,
                     needs(cells));
    Resolution result;
    result.cells = grid.cell.size();
    PolygridDiffusion diffusion(grid, problems_[0].mesh, problems_[0].surface, problems_[0].eta,
                                options_.device);
    std::vector<const ObjectMedium*> media;
    for (const ObjectProblem& problem : problems_) media.push_back(&problem.medium);
    diffusion.set_media(media);
    const Stopwatch watch;
    result.channel = diffusion.solve(problems_, {});
    result.solving = watch.seconds();
    result.report = diffusion.report();
    result.gaps = diffusion.surface_map().gaps();
    solving_ += result.solving;
    return result;
  }

  /// Sets the results of the finer one, with its error.
  void estimate_errors(const Resolution& coarse, const Resolution& fine) {
    worst_ = gap_free_ = 0.0;
    for (std::size_t c = 0; c < problems_.size(); ++c) {
      ObjectResult& result = results_[c];
      const std::vector<double>& a = coarse.channel[c].exitance;
      const std::vector<double>& b = fine.channel[c].exitance;
      result.error_estimate = polygrid_errors(problems_[c], fine.gaps, a, b);
      for (const double error : result.error_estimate) worst_ = std::max(worst_, error);
      for (const double error : polygrid_errors(problems_[c], {}, a, b)) {
        gap_free_ = std::max(gap_free_, error);
      }
      result.exitance = b;
      result.balance = fine.channel[c].balance;
      result.leaving = fine.channel[c].leaving;
      result.elements = fine.cells;
      result.iterations = fine.report.iterations;
      result.converged = fine.report.converged && worst_ <= options_.tolerance;
    }
    solved_ = fine.report.converged;
    cells_ = static_cast<double>(fine.cells);
    progress_.update("polygrid", std::min(1.0, options_.tolerance / std::max(worst_, 1e-300)),
                     formatted("%zu cells, error %g", fine.cells, worst_));
  }

  std::string conclusion() const {
    if (!solved_) return "the linear solver stopped before its tolerance";
    if (worst_ <= options_.tolerance) {
      return formatted("the estimated error %g is within the tolerance", worst_);
    }
    return formatted(
               "stopped at %.0f cells with an estimated error of %g%s: the tolerance needs "
               "about ",
               cells_, worst_,
               gap_free_ <= options_.tolerance
                   ? ", as parts of the surface lie outside of the polygrid"
                   : "") +
           needs(needed_) + ", more than the " + allowed();
  }

  std::vector<ObjectResult> finished() {
    const double spent = watch_.seconds();
    for (ObjectResult& result : results_) {
      result.seconds = solving_;
      result.setup_seconds = spent - solving_;
      result.converged = solved_ && worst_ <= options_.tolerance;
      result.message = conclusion();
      if (!result.converged) result.warnings.push_back(result.message);
    }
    return std::move(results_);
  }

  std::span<const ObjectProblem> problems_;
  const ObjectOptions& options_;
  Progress& progress_;
  const Stopwatch watch_;
  std::vector<ObjectResult> results_;
  double bytes_each_ = bytes_per_cell;  ///< of a cell
  double most_ = 0.0;                   ///< cells
  double cells_ = 0.0, worst_ = 0.0;    ///< of the results
  double gap_free_ = 0.0;               ///< the worst error without what gaps leave out
  double needed_ = 0.0, solving_ = 0.0;
  bool solved_ = false;
};

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

double polygrid_cells_needed(double cells, double error, double tolerance, double order) {
  return cells * std::pow(error / tolerance, 3.0 / order);
}

double polygrid_order(double cells_before, double error_before, double cells, double error) {
  const double order = 3.0 * std::log(error_before / error) / std::log(cells / cells_before);
  return std::clamp(order, least_order, greatest_order);
}

std::vector<ObjectResult> solve_on_polygrid(Polygrid first, std::span<const ObjectProblem> problems,
                                            const ObjectOptions& options, Progress& progress,
                                            const PolygridMaker& maker) {
  for (const ObjectProblem& problem : problems) check_problem(problem, options);
  if (problems.empty()) return {};
  return with_reentry(problems, options,
                      [&](std::span<const ObjectProblem> asked, const ObjectOptions& how) {
                        return PolygridSolve(asked, how, progress).run(first, maker);
                      });
}

}  // namespace kappamu::forward
