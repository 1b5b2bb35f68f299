#include "inverse/distributed/distributed_fit.h"

#include <petsctao.h>

#include <cmath>
#include <exception>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "inverse/defaults.h"
#include "inverse/fit/path_rules.h"

namespace kappamu::inverse::distributed {

namespace {

using forward::distributed::ConstValues;
using forward::distributed::Owned;
using forward::distributed::petsc;
using forward::distributed::Values;
using forward::distributed::Vector;

using Optimiser = Owned<Tao, TaoDestroy>;

/// What TAO's callbacks see of one weight.
struct Stage {
  PieceObjective& objective;
  FitReport& report;
  const PathOptions& path;
  Progress& progress;
  double weight;
  double seconds_before;
  Stopwatch watch{};
  double last = 0.0;   ///< objective of the step before
  double scale = 0.0;  ///< of the objective, so that the first step, the gradient, is of first_step
  int small_decreases = 0;
  bool ran_out = false;
  std::exception_ptr failure{};
};

/// Largest change of log κ or log μ in the first step at a weight, before L-BFGS knows any scale.
constexpr double first_step = 0.1;

PetscErrorCode value_and_gradient(Tao, Vec x, PetscReal* value, Vec gradient, void* context) {
  Stage& stage = *static_cast<Stage*>(context);
  try {
    const std::size_t size = stage.objective.size();
    const ConstValues at(x);
    *value = stage.objective.value({&at[0], size});
    if (std::isfinite(*value)) {
      {
        const Values slope(gradient);
        stage.objective.gradient({&slope[0], size});
      }
      if (stage.scale == 0.0) {
        PetscReal largest = 0.0;
        petsc(VecNorm(gradient, NORM_INFINITY, &largest));
        stage.scale = largest > 0.0 ? first_step / largest : 1.0;
      }
      petsc(VecScale(gradient, stage.scale));
      *value *= stage.scale;
    } else {
      // A line search that has gone astray comes back from a large value, and does not stand still.
      constexpr double beyond = 100.0;
      *value = beyond * stage.scale * stage.last;
      petsc(VecZeroEntries(gradient));
    }
    return 0;
  } catch (...) {
    stage.failure = std::current_exception();
    return PETSC_ERR_USER;
  }
}

/// As minimise.cpp: a minimum is found where steps in a row lower the objective little.
PetscErrorCode test_convergence(Tao tao, void* context) {
  Stage& stage = *static_cast<Stage*>(context);
  PetscInt step = 0;
  PetscReal value = 0.0, gradient = 0.0;
  PetscCall(TaoGetSolutionStatus(tao, &step, &value, &gradient, nullptr, nullptr, nullptr));
  value /= stage.scale;
  stage.report.history.push_back({.weight = stage.weight,
                                  .step = static_cast<int>(step),
                                  .solves = stage.objective.solves(),
                                  .objective = value,
                                  .chi2_per_value = stage.objective.chi2_per_value(),
                                  .roughness = stage.objective.roughness(),
                                  .seconds = stage.seconds_before + stage.watch.seconds()});
  stage.progress.update("fit", 0.0,
                        formatted("weight %.3g, step %d: chi2 per value %.4g", stage.weight,
                                  static_cast<int>(step), stage.objective.chi2_per_value()));
  if (step > 0) {
    const bool small = stage.last - value < stage.path.final_tolerance * value;
    stage.small_decreases = small ? stage.small_decreases + 1 : 0;
  }
  stage.last = value;
  TaoConvergedReason reason = TAO_CONTINUE_ITERATING;
  if (stage.small_decreases >= defaults::few_decreases || gradient == 0.0) {
    reason = TAO_CONVERGED_USER;
  } else if (step >= stage.path.stage_steps) {
    reason = TAO_DIVERGED_MAXITS;
    stage.ran_out = true;
  }
  PetscCall(TaoSetConvergedReason(tao, reason));
  return 0;
}

Optimiser make_optimiser(MPI_Comm comm, Stage& stage, Vec x) {
  Optimiser optimiser;
  petsc(TaoCreate(comm, optimiser.receive()));
  Tao tao = optimiser.get();
  petsc(TaoSetOptionsPrefix(tao, "kappamu_"));
  petsc(TaoSetType(tao, TAOLMVM));
  petsc(TaoSetSolution(tao, x));
  petsc(TaoSetObjectiveAndGradient(tao, nullptr, value_and_gradient, &stage));
  petsc(TaoSetConvergenceTest(tao, test_convergence, &stage));
  petsc(TaoSetFromOptions(tao));
  return optimiser;
}

/// From x to the minimum at the stage's weight.
void minimise(MPI_Comm comm, Stage& stage, Vec x) {
  stage.objective.set_weight(stage.weight);
  const Optimiser optimiser = make_optimiser(comm, stage, x);
  const PetscErrorCode code = TaoSolve(optimiser.get());
  if (stage.failure) std::rethrow_exception(stage.failure);
  petsc(code);
  // The last value() may have been a trial of the line search.
  const ConstValues at(x);
  stage.objective.value({&at[0], stage.objective.size()});
}

std::string reason_of(const FitReport& report, bool ran_out) {
  const std::string where = formatted("chi2 per value %.3g", report.chi2_per_value);
  if (ran_out) return "the last weight ran out of steps at " + where;
  switch (report.end) {
    case PathEnd::noise:
      return "the objective stopped falling at " + where + ", the noise of the data";
    case PathEnd::asked:
      return "the objective stopped falling at " + where + " under the weight asked for";
    default:
      return "the lowest weight ended the path at " + where;
  }
}

PathState begin(const BlockPieces& pieces, const Problem& problem) {
  PathState state;
  const HomogeneousFit start = find_start(pieces, problem);
  FitReport& report = state.report;
  report.homogeneous_kappa = start.kappa;
  report.homogeneous_mu = start.mu;
  report.homogeneous_log_residual = start.log_residual;
  report.model.model = Model::volume;
  report.model.reason = "kappamu-mpi fits volumes alone";
  if (!start.converged) {
    report.warnings.emplace_back(
        "The homogeneous start did not converge; the volumes may depend on where it stopped.");
  }
  const std::size_t cells = pieces.owned().cells();
  state.own.assign(cells, std::log(start.kappa));
  state.own.insert(state.own.end(), cells, std::log(start.mu));
  return state;
}

}  // namespace

PieceFit fit_pieces(std::shared_ptr<const BlockPieces> pieces, const Problem& problem,
                    const FitOptions& options, const PathCheckpoint& checkpoint,
                    Progress& progress) {
  const Stopwatch watch;
  forward::distributed::require_countable(2 * pieces->whole().shape.cells());
  std::optional<PathState> saved = checkpoint.load();
  PathState state = saved ? std::move(*saved) : begin(*pieces, problem);
  FitReport& report = state.report;
  report.resumed = saved.has_value();
  const double thickness = pieces->whole().thickness_mm();
  const Anchor anchor{std::log(report.homogeneous_kappa), std::log(report.homogeneous_mu),
                      options.regulariser.anchor_length * thickness};
  PieceObjective objective(pieces, problem, options.solver.backend, anchor);
  report.backend = objective.backend_name();
  report.data = static_cast<std::size_t>(objective.used());

  Vector x;
  petsc(VecCreateMPI(pieces->comm(), static_cast<PetscInt>(objective.size()), PETSC_DETERMINE,
                     x.receive()));
  {
    const Values own(x.get());
    for (std::size_t i = 0; i < state.own.size(); ++i) own[i] = state.own[i];
  }
  if (!saved) {
    objective.value(state.own);
    state.weight = first_weight(options.path, objective.chi2_per_value());
  }
  const double seconds_before = state.seconds;
  bool ran_out = false;
  for (;;) {
    Stage stage{objective, report,       options.path,
                progress,  state.weight, seconds_before + watch.seconds()};
    minimise(pieces->comm(), stage, x.get());
    ran_out = stage.ran_out;
    const double chi2 = objective.chi2_per_value();
    report.chi2_per_value = chi2;
    report.weight = state.weight;
    report.end = end_of_path(options.path, state.weight, {chi2, chi2}, std::nullopt, 0.0);
    if (report.end != PathEnd::unknown) break;
    state.weight *= options.path.weight_factor;
    state.seconds = seconds_before + watch.seconds();
    const ConstValues own(x.get());
    for (std::size_t i = 0; i < state.own.size(); ++i) state.own[i] = own[i];
    checkpoint.save(state);
  }
  const bool above = report.end == PathEnd::lowest;
  report.status = ran_out ? FitStatus::ran_out
                  : above ? FitStatus::above_noise
                          : FitStatus::converged;
  report.reason = reason_of(report, ran_out);
  report.solves = objective.solves();
  report.seconds = seconds_before + watch.seconds();
  return {objective.fields(), objective.prediction(), std::move(report)};
}

}  // namespace kappamu::inverse::distributed
