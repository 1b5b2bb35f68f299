#include "studies/baseline/baseline_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/error.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "device/context.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/rounding_floor.h"
#include "studies/baseline/diagonal_cg.h"
#include "studies/baseline/hierarchy.h"

namespace kappamu::studies::baseline {

using namespace forward;

namespace {

/// [W] lets the user choose how deep each level computes. Eight cells keep [W]'s error measure
/// Σ(L−L₀)²/ΣL₀² below its 0.5 % on every block tried (tests/studies/baseline/model_test.cpp).
constexpr int adaptive_depth = 8;

/// What one method does between light and fluence; everything else is the same for all.
class Solver {
 public:
  virtual ~Solver() = default;
  struct Outcome {
    int iterations = 0;
    Termination termination = Termination::failed;
    std::vector<double> residual;  ///< [pattern of the batch]
    std::string message;
  };
  /// Solves for the batch's patterns, from b to φ, both [cell][lane] on the device; the caller
  /// times it.
  virtual Outcome solve(const Batch& batch, const device::Buffer& b,
                        const SolveOptions& options) = 0;
  /// Copies the last solution to its place in [pattern][cell].
  virtual void read(const Batch& batch, std::span<double> phi) const = 0;
};

class RelaxationSolver final : public Solver {
 public:
  RelaxationSolver(const Batch& batch, const GridSolver& grid, const Medium& medium,
                   baseline::Relaxation kind, const baseline::HierarchyOptions& hierarchy)
      : kind_(kind),
        cells_(grid.setup().shape.cells()),
        levels_(batch, grid.setup(), grid.constants().A, medium, hierarchy) {}

  Outcome solve(const Batch& batch, const device::Buffer& b, const SolveOptions& options) override {
    phi_ = batch.make_field(cells_);
    const auto result = levels_.solve(batch, b, phi_, kind_, options);
    std::string message = sentence(result.finest, options.tolerance, batch.precision());
    if (!result.coarse_sweeps.empty()) {
      message += ", coarser grids";
      for (const int sweeps : result.coarse_sweeps) message += " " + std::to_string(sweeps);
    }
    const double worst =
        *std::max_element(result.finest.residual.begin(), result.finest.residual.end());
    const Termination termination = result.finest.converged ? Termination::converged
                                    : std::isfinite(worst)  ? Termination::ran_out
                                                            : Termination::failed;
    return {result.finest.sweeps, termination, result.finest.residual, message};
  }

  void read(const Batch& batch, std::span<double> phi) const override {
    batch.read(phi_, cells_, phi);
  }

 private:
  baseline::Relaxation kind_;
  std::size_t cells_;
  baseline::CoarseToFine levels_;
  device::Buffer phi_;
};

class Wang2008Solver final : public Solver {
 public:
  Wang2008Solver(const Batch& batch, const GridSolver& grid, const Medium& medium)
      : kappa_(medium.kappa.values()),
        stencil_(batch.upload(baseline::wang2008_stencil(grid.setup(), grid.constants().A, kappa_,
                                                         medium.mu.values()))) {}

  Outcome solve(const Batch& batch, const device::Buffer& b, const SolveOptions& options) override {
    product_ = batch.make_accurate_field(stencil_.cells());
    const auto result = baseline::diagonal_cg(batch, stencil_, b, product_, options);
    const double worst = *std::max_element(result.residual.begin(), result.residual.end());
    const bool converged = worst <= options.tolerance;
    std::string message =
        formatted("relative residual %g after %d iterations on the equations of stencil (8)", worst,
                  result.iterations);
    if (!converged) message += formatted(", tolerance %g not met", options.tolerance);
    if (result.stagnated) message += ": " + rounding_floor_sentence(batch.precision());
    const Termination termination = converged              ? Termination::converged
                                    : std::isfinite(worst) ? Termination::ran_out
                                                           : Termination::failed;
    return {result.iterations, termination, result.residual, message};
  }

  void read(const Batch& batch, std::span<double> phi) const override {
    const std::size_t cells = kappa_.size();
    batch.read_accurate(product_, cells, phi);
    const auto first = static_cast<std::size_t>(batch.first());
    for (std::size_t m = first; m < first + static_cast<std::size_t>(batch.patterns()); ++m) {
      for (std::size_t i = 0; i < cells; ++i) phi[m * cells + i] /= kappa_[i];
    }
  }

 private:
  std::vector<double> kappa_;
  baseline::DeviceStencil stencil_;
  device::Buffer product_;  ///< κφ
};

enum class Kind { relaxation, gauss_seidel, hierarchical, adaptive, wang2008_stencil };

const char* name_of(Kind kind) {
  switch (kind) {
    case Kind::relaxation:
      return "relaxation";
    case Kind::gauss_seidel:
      return "gauss-seidel";
    case Kind::hierarchical:
      return "hierarchical";
    case Kind::adaptive:
      return "adaptive";
    case Kind::wang2008_stencil:
      break;
  }
  return "wang2008-stencil";
}

class BaselineModel final : public ForwardModel {
 public:
  explicit BaselineModel(Kind kind) : kind_(kind) {}

  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                      Progress& progress) const override {
    if (options.device == "reference") {
      throw InputError(std::string("method '") + name_of(kind_) +
                       "' runs on OpenCL devices only; choose another --device");
    }
    const SolverChoice choice = make_grid_solver(problem.setup, options.device, options.precision);
    if (!choice.warning.empty()) {
      throw InputError(std::string("method '") + name_of(kind_) +
                       "' has no serial form to fall back on, and the device failed its "
                       "known-answer test; use another --device or --method reference");
    }
    GridSolver& grid = *choice.solver;
    grid.set_medium(problem.medium.kappa.values(), problem.medium.mu.values());
    const std::size_t cells = problem.setup.shape.cells();
    std::vector<double> phi(cells * static_cast<std::size_t>(problem.patterns));
    {
      const auto b = grid.make_field(problem.patterns);
      grid.light_source(problem.irradiance, *b);
      grid.read(*b, phi);  // each batch's b gives way to its φ
    }

    device::Context& context = device::Context::chosen(options.device);
    const std::vector<baseline::Lanes> blocks = baseline::cut_into_lanes(problem.patterns);
    const Batch first(context, options.precision, blocks.front());  // compiles the kernels
    const Stopwatch setting_up;
    const auto solver = make_solver(first, grid, problem);
    context.finish();
    ForwardResult result;
    result.backend = grid.backend();
    result.setup_seconds = setting_up.seconds();
    result.termination = Termination::converged;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      progress.update(name_of(kind_), static_cast<double>(k) / static_cast<double>(blocks.size()),
                      "");
      const Batch batch(context, options.precision, blocks[k]);
      const device::Buffer b = batch.make_field(cells);
      batch.write(b, cells, phi);
      context.finish();
      const Stopwatch solving;
      const Solver::Outcome outcome = solver->solve(batch, b, options.solve);
      context.finish();
      result.seconds += solving.seconds();
      add(outcome, result);
      solver->read(batch, phi);
    }
    report_light(problem, grid, phi, result);
    return result;
  }

 private:
  std::unique_ptr<Solver> make_solver(const Batch& batch, const GridSolver& grid,
                                      const ForwardProblem& problem) const {
    if (kind_ == Kind::wang2008_stencil) {
      return std::make_unique<Wang2008Solver>(batch, grid, problem.medium);
    }
    baseline::HierarchyOptions hierarchy;
    if (kind_ == Kind::hierarchical || kind_ == Kind::adaptive) {
      hierarchy.levels = baseline::all_levels;
    }
    if (kind_ == Kind::adaptive) {
      hierarchy.active.depth = adaptive_depth;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        hierarchy.active.open[axis] = is_open(problem.setup, all_faces[2 * axis]);
      }
    }
    const auto relaxation = kind_ == Kind::gauss_seidel ? baseline::Relaxation::gauss_seidel
                                                        : baseline::Relaxation::jacobi;
    return std::make_unique<RelaxationSolver>(batch, grid, problem.medium, relaxation, hierarchy);
  }

  /// Batches are solved one after the other; the slowest and the worst speak for all.
  static void add(const Solver::Outcome& outcome, ForwardResult& result) {
    const bool worse = static_cast<int>(outcome.termination) > static_cast<int>(result.termination);
    if (result.message.empty() || worse ||
        (outcome.termination == result.termination && outcome.iterations > result.iterations)) {
      result.message = outcome.message;
    }
    if (worse) result.termination = outcome.termination;
    result.iterations = std::max(result.iterations, outcome.iterations);
    result.residual.insert(result.residual.end(), outcome.residual.begin(), outcome.residual.end());
  }

  static void report_light(const ForwardProblem& problem, const GridSolver& grid,
                           const std::vector<double>& phi, ForwardResult& result) {
    const auto field = grid.make_field(problem.patterns);
    grid.fill(*field, phi);
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      const Face face = all_faces[f];
      result.exitance[f].resize(face_shape(problem.setup.shape, face).cells() *
                                static_cast<std::size_t>(problem.patterns));
      const bool lit = face == problem.setup.lit_face;
      grid.exitance(*field, face,
                    lit ? std::span<const double>(problem.irradiance) : std::span<const double>(),
                    result.exitance[f]);
    }
    result.balance =
        power_balance(grid, problem.medium, *field, problem.irradiance, result.exitance);
  }

  Kind kind_;
};

struct Entry {
  const char *name, *description;
  Kind kind;
};
constexpr std::array entries{
    Entry{"relaxation", "Jacobi relaxation (Stam 1995, [W] 5.2) on our grid equations",
          Kind::relaxation},
    Entry{"gauss-seidel", "red-black Gauss-Seidel relaxation ([T] 4.2.2) on our grid equations",
          Kind::gauss_seidel},
    Entry{"hierarchical", "[W] 5.3: coarser grids' solutions start the relaxation of finer ones",
          Kind::hierarchical},
    Entry{"adaptive", "[W] 5.3: hierarchical, leaving voxels deep inside at their coarse values",
          Kind::adaptive},
    Entry{"wang2008-stencil",
          "[W] equation (8), which discretises div grad (kappa phi), solved out",
          Kind::wang2008_stencil}};

}  // namespace

const std::vector<MethodName>& methods() {
  static const std::vector<MethodName> names = [] {
    std::vector<MethodName> list;
    for (const Entry& entry : entries) list.push_back({entry.name, entry.description});
    return list;
  }();
  return names;
}

std::unique_ptr<ForwardModel> make_model(const std::string& method) {
  for (const Entry& entry : entries) {
    if (method == entry.name) return std::make_unique<BaselineModel>(entry.kind);
  }
  return make_forward_model(method);
}

}  // namespace kappamu::studies::baseline
