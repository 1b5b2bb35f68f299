#include "forward/grid/grid_model.h"

#include <span>
#include <vector>

#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/grid/grid_physics.h"

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
    validate(problem.setup, problem.light, problem.patterns);
    ForwardResult result;
    result.backend = solver.backend();
    if (!choice.warning.empty()) result.warnings.push_back(choice.warning);
    for (const PointSource& point : problem.light.points) warn_near_face(problem, point, result);

    const Stopwatch watch;
    solver.set_medium(problem.medium.kappa.values(), problem.medium.mu.values());
    result.setup_seconds = watch.seconds();

    const auto b = solver.make_field(problem.patterns);
    const auto phi = solver.make_field(problem.patterns);
    const std::vector<double> at_normal = problem.light.direction
                                              ? std::vector<double>(problem.irradiance.size(), 0.0)
                                              : problem.irradiance;
    solver.light_source(at_normal, *b);
    const LightLoad load = add_light(problem, solver, *b);
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
    result.balance = power_balance(solver, problem.medium, *phi, at_normal, result.exitance);
    for (std::size_t m = 0; m < load.entering.size(); ++m) {
      result.balance[m].entering += load.entering[m];
      result.balance[m].absorbed += load.absorbed[m];
      result.balance[m].unscattered += load.unscattered[m];
    }
    if (options.fluence) {
      result.fluence.resize(problem.setup.shape.cells() *
                            static_cast<std::size_t>(problem.patterns));
      solver.read(*phi, result.fluence);
    }
    return result;
  }

 private:
  /// Within a mean free path 3κ of a face diffusion does not know where the light goes.
  static void warn_near_face(const ForwardProblem& problem, const PointSource& point,
                             ForwardResult& result) {
    const GridShape& shape = problem.setup.shape;
    const Eigen::Vector3i cell = (point.position_mm / shape.voxel_mm).cast<int>();
    const double path = 3.0 * problem.medium.kappa[shape.index(cell.x(), cell.y(), cell.z())];
    for (const Face face : all_faces) {
      const int axis = axis_of(face);
      const double at = point.position_mm[axis];
      const double depth = is_plus(face) ? shape.extent(axis) * shape.voxel_mm - at : at;
      if (!is_open(problem.setup, face) || depth > path) continue;
      result.warnings.push_back(
          formatted("the point %g mm below face %s is less than a mean free path 3 kappa = %g mm "
                    "away from it; diffusion is inaccurate there: compare with montecarlo",
                    depth, to_string(face).c_str(), path));
    }
  }

  /// Adds to b what is not irradiance at normal incidence; returns nothing where there is none.
  static LightLoad add_light(const ForwardProblem& problem, const GridSolver& solver,
                             BatchField& b) {
    if (problem.light.plain()) return {};
    LightLoad load = light_load(problem.setup, problem.medium, problem.light, problem.irradiance,
                                problem.patterns);
    std::vector<double> sum(load.source.size());
    solver.read(b, sum);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += load.source[i];
    solver.fill(b, sum);
    return load;
  }

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
