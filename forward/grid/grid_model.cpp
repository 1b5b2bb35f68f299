#include "forward/grid/grid_model.h"

#include <span>

#include "core/processor_time.h"

namespace kappamu::forward {

namespace {

class GridModel final : public ForwardModel {
 public:
  explicit GridModel(bool reference) : reference_(reference) {}

  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                      Progress& /*progress*/) const override {
    const std::string device = reference_ ? "reference" : options.device;
    const SolverChoice choice = make_grid_solver(problem.setup, device, options.precision);
    GridSolver& solver = *choice.solver;
    ForwardResult result;
    result.backend = solver.backend();
    if (!choice.warning.empty()) result.warnings.push_back(choice.warning);

    const Stopwatch watch;
    solver.set_medium(problem.medium.kappa.values(), problem.medium.mu.values());
    result.setup_seconds = watch.seconds();

    const auto b = solver.make_field(problem.patterns);
    const auto phi = solver.make_field(problem.patterns);
    solver.light_source(problem.irradiance, *b);
    const SolveReport report = solver.solve(*b, *phi, options.solve);
    result.termination = report.termination;
    result.message = report.message;
    result.iterations = report.iterations;
    result.seconds = report.seconds;
    result.residual = report.residual;
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      const Face face = all_faces[f];
      result.exitance[f].resize(face_shape(problem.setup.shape, face).cells() *
                                static_cast<std::size_t>(problem.patterns));
      const bool lit = face == problem.setup.lit_face;
      solver.exitance(*phi, face,
                      lit ? std::span<const double>(problem.irradiance) : std::span<const double>(),
                      result.exitance[f]);
    }
    result.balance =
        power_balance(solver, problem.medium, *phi, problem.irradiance, result.exitance);
    return result;
  }

 private:
  bool reference_;
};

}  // namespace

std::unique_ptr<ForwardModel> make_multigrid_model() {
  return std::make_unique<GridModel>(false);
}

std::unique_ptr<ForwardModel> make_reference_model() {
  return std::make_unique<GridModel>(true);
}

}  // namespace kappamu::forward
