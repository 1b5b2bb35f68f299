#include "inverse/problem/objective.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/grid/grid_physics.h"
#include "inverse/problem/linearised.h"

namespace kappamu::inverse {

namespace {

/// Pixels of the seen face that a thread sums over the patterns at once.
constexpr std::size_t seen_at_once = 4096;

using forward::SolveReport;
using forward::Termination;

bool within_range(const CoefficientPair& fields) {
  const auto ok = [](double x) { return std::abs(x) <= max_log_coefficient; };  // false for NaN
  return for_all(fields.log_mu.size(),
                 [&](std::size_t i) { return ok(fields.log_kappa[i]) && ok(fields.log_mu[i]); });
}

/// Voxels times iterations of a batch of `part` out of `patterns`.
double cost(const forward::GridSolver& solver, const SolveReport& report, int part, int patterns) {
  return static_cast<double>(solver.setup().shape.cells()) * report.iterations * part / patterns;
}

/// Patterns [begin, end) of an array [M][...].
std::span<const double> patterns_of(const std::vector<double>& values, int begin, int end,
                                    std::size_t cells) {
  return std::span<const double>(values).subspan(static_cast<std::size_t>(begin) * cells,
                                                 static_cast<std::size_t>(end - begin) * cells);
}

}  // namespace

Refinement refine(const Problem& problem) {
  Refinement refinement;
  refinement.setup = problem.setup;
  refinement.setup.shape = problem.setup.shape.refined(2);
  refinement.irradiance =
      split_face(problem.irradiance, problem.lit_shape(),
                 face_shape(refinement.setup.shape, problem.setup.lit_face), 2, problem.patterns);
  return refinement;
}

std::vector<double> solve_exitance(forward::GridSolver& solver, Face face,
                                   const std::vector<double>& irradiance, int patterns, int batch,
                                   const forward::SolveOptions& options, double* voxel_iterations) {
  const std::size_t lit = face_shape(solver.setup().shape, solver.setup().lit_face).cells();
  const std::size_t seen = face_shape(solver.setup().shape, face).cells();
  std::vector<double> exitance(seen * static_cast<std::size_t>(patterns));
  for (int begin = 0; begin < patterns; begin += batch) {
    const int end = std::min(begin + batch, patterns);
    const auto light = patterns_of(irradiance, begin, end, lit);
    const auto b = solver.make_field(end - begin);
    const auto phi = solver.make_field(end - begin);
    solver.light_source(light, *b);
    const SolveReport report = solver.solve(*b, *phi, options);
    if (report.termination == Termination::failed) {
      throw InputError("the diffusion solver failed: " + report.message);
    }
    if (voxel_iterations != nullptr) {
      *voxel_iterations += cost(solver, report, end - begin, patterns);
    }
    const bool needs_light = face == solver.setup().lit_face;
    solver.exitance(
        *phi, face, needs_light ? light : std::span<const double>(),
        std::span<double>(exitance).subspan(static_cast<std::size_t>(begin) * seen,
                                            static_cast<std::size_t>(end - begin) * seen));
  }
  return exitance;
}

int bounded_batch(const GridShape& shape, int batch, double memory_mb,
                  forward::Precision precision) {
  // Right-hand side, solution, three vectors of conjugate gradients, multigrid's own (8/7 of two).
  constexpr double fields = 8.0;
  const double bytes = precision == forward::Precision::single_precision ? 4.0 : 8.0;
  const double per_pattern_mb = fields * bytes * static_cast<double>(shape.cells()) / 1048576.0;
  const int most = std::clamp(static_cast<int>(memory_mb / per_pattern_mb), 1, batch);
  // Patterns are solved 16, 8, 4 or 1 at a time: six would take the time and memory of eight.
  return most >= batch || most >= 16 ? most : most >= 8 ? 8 : most >= 4 ? 4 : 1;
}

Objective::Objective(Problem problem, Backend backend, DataTermOptions data_term)
    : problem_(std::move(problem)),
      backend_(std::move(backend)),
      derivative_solve_(backend_.solve),
      data_options_(data_term) {
  forward::SolverChoice choice =
      forward::make_grid_solver(problem_.setup, backend_.device, backend_.precision);
  solver_ = std::move(choice.solver);
  warning_ = std::move(choice.warning);
  stated_weight_ = problem_.weight;
  correction_.ratio.assign(problem_.data.size(), 1.0);
  ratio_ = correction_.ratio;
}

void Objective::set_derivative_tolerance(double tolerance) {
  derivative_solve_.tolerance = tolerance;
}

/// False where there is no solution to speak of. Solves nothing where it has just solved.
bool Objective::solve_forward(const CoefficientPair& fields) {
  if (!fluence_.empty() && fields == fields_) return true;
  fluence_.clear();
  if (!within_range(fields)) return false;
  fields_ = fields;
  kappa_ = exponential(fields.log_kappa);
  mu_ = exponential(fields.log_mu);
  solver_->set_medium(kappa_, mu_);
  ++solves_.forward;
  const std::size_t lit = problem_.lit_shape().cells();
  const std::size_t seen = problem_.seen_shape().cells();
  exitance_.assign(problem_.data.size(), 0.0);
  for (int begin = 0; begin < problem_.patterns; begin += backend_.batch) {
    const int end = std::min(begin + backend_.batch, problem_.patterns);
    const auto light = patterns_of(problem_.irradiance, begin, end, lit);
    const auto b = solver_->make_field(end - begin);
    auto phi = solver_->make_field(end - begin);
    solver_->light_source(light, *b);
    // From zero, never from the last solution: a resumed fit must repeat the same arithmetic.
    const SolveReport report = solver_->solve(*b, *phi, backend_.solve);
    solves_.voxel_iterations += cost(*solver_, report, end - begin, problem_.patterns);
    if (report.termination == Termination::failed) {
      fluence_.clear();
      return false;
    }
    const bool needs_light = problem_.seen_face == problem_.setup.lit_face;
    solver_->exitance(
        *phi, problem_.seen_face, needs_light ? light : std::span<const double>(),
        std::span<double>(exitance_).subspan(static_cast<std::size_t>(begin) * seen,
                                             static_cast<std::size_t>(end - begin) * seen));
    fluence_.push_back(std::move(phi));
  }
  correct();
  return true;
}

double Objective::misfit() {
  data_term_ = evaluate(problem_, prediction(), data_options_);
  return data_term_.value;
}

double Objective::value(const CoefficientPair& fields) {
  return solve_forward(fields) ? misfit() : std::numeric_limits<double>::infinity();
}

CoefficientPair Objective::gradient() {
  std::vector<double> by_exitance = data_term_.by_prediction;
  for (std::size_t i = 0; i < by_exitance.size(); ++i) by_exitance[i] *= ratio_[i];
  return adjoint(by_exitance);
}

CoefficientPair Objective::jacobian_transpose(const std::vector<double>& probe) {
  std::vector<double> by_exitance(exitance_.size());
  for (std::size_t i = 0; i < exitance_.size(); ++i) {
    by_exitance[i] = probe[i] * ratio_[i] * data_term_.root_weight[i];
  }
  return adjoint(by_exitance);
}

std::vector<double> Objective::jacobian(const CoefficientPair& direction) {
  check(!fluence_.empty(), "a derivative needs the fluence of a successful value()");
  ++solves_.tangent;
  const std::size_t lit = problem_.lit_shape().cells();
  const std::size_t seen = problem_.seen_shape().cells();
  const Tangent tangent =
      linearise(problem_.setup, solver_->constants(), problem_.seen_face, kappa_, mu_, direction);
  std::vector<double> change(exitance_.size());
  for (std::size_t part = 0; part < fluence_.size(); ++part) {
    const int begin = static_cast<int>(part) * backend_.batch;
    const int end = std::min(begin + backend_.batch, problem_.patterns);
    const auto b = solver_->make_field(end - begin);
    const auto field = solver_->make_field(end - begin);
    solver_->change_source(tangent.equations, *fluence_[part],
                           patterns_of(problem_.irradiance, begin, end, lit), *b);
    const SolveReport report = solver_->solve(*b, *field, derivative_solve_);
    if (report.termination == Termination::failed) {
      throw InputError("the linearised diffusion solve failed: " + report.message);
    }
    solves_.voxel_iterations += cost(*solver_, report, end - begin, problem_.patterns);
    // Light is none of δφ's doing: where the lit face is seen, exitance() must not add it.
    const std::vector<double> dark(static_cast<std::size_t>(end - begin) * lit, 0.0);
    solver_->exitance(
        *field, problem_.seen_face,
        problem_.seen_face == problem_.setup.lit_face ? dark : std::span<const double>(),
        std::span<double>(change).subspan(static_cast<std::size_t>(begin) * seen,
                                          static_cast<std::size_t>(end - begin) * seen));
  }
  const double apart = exitance_apart();
  const std::array<double, 2> even = means(direction);
  for (std::size_t i = 0; i < change.size(); ++i) {
    const double entered = apart == 0.0 ? 0.0 : apart * problem_.irradiance[i];
    change[i] += tangent.observed[i % seen] * (exitance_[i] - entered);
    for (std::size_t k = 0; k < 2 && !correction_.slope[k].empty(); ++k) {
      change[i] += correction_.slope[k][i] * even[k] * exitance_[i];
    }
    change[i] *= ratio_[i] * data_term_.root_weight[i];
  }
  return change;
}

void Objective::weigh(std::vector<double>& residuals) const {
  if (shares_errors(problem_, data_options_)) problem_.precision->apply(residuals);
}

void Objective::weigh_root(std::vector<double>& white) const {
  if (shares_errors(problem_, data_options_)) problem_.precision->apply_root(white);
}

/// The part of the exitance that no conductance multiplies, per irradiance.
double Objective::exitance_apart() const {
  return problem_.seen_face == problem_.setup.lit_face
             ? forward::exitance_per_irradiance(problem_.setup, solver_->constants())
             : 0.0;
}

CoefficientPair Objective::adjoint(const std::vector<double>& by_exitance) {
  check(!fluence_.empty(), "a gradient needs the fluence of a successful value()");
  ++solves_.adjoint;
  const std::size_t lit = problem_.lit_shape().cells();
  const std::size_t seen = problem_.seen_shape().cells();
  const double apart = exitance_apart();
  AdjointSums sums;
  for (std::size_t part = 0; part < fluence_.size(); ++part) {
    const int begin = static_cast<int>(part) * backend_.batch;
    const int end = std::min(begin + backend_.batch, problem_.patterns);
    const auto b = solver_->make_field(end - begin);
    const auto lambda = solver_->make_field(end - begin);
    solver_->exitance_adjoint(problem_.seen_face, patterns_of(by_exitance, begin, end, seen), *b);
    const SolveReport report = solver_->solve(*b, *lambda, derivative_solve_);
    if (report.termination == Termination::failed) {
      throw InputError("the adjoint diffusion solve failed: " + report.message);
    }
    solves_.voxel_iterations += cost(*solver_, report, end - begin, problem_.patterns);
    AdjointSums term;
    term.products = solver_->pair_products(*lambda, *fluence_[part]);
    term.columns =
        solver_->column_products(*lambda, patterns_of(problem_.irradiance, begin, end, lit));
    term.observed.assign(seen, 0.0);
    for_pieces(seen, seen_at_once, [&](std::size_t, std::size_t first, std::size_t last) {
      for (int m = begin; m < end; ++m) {
        for (std::size_t s = first; s < last; ++s) {
          const std::size_t i = static_cast<std::size_t>(m) * seen + s;
          const double entered = apart == 0.0 ? 0.0 : apart * problem_.irradiance[i];
          term.observed[s] += by_exitance[i] * (exitance_[i] - entered);
        }
      }
    });
    sums.add(std::move(term));
  }
  CoefficientPair gradient = assemble_gradient(problem_.setup, solver_->constants(),
                                               problem_.seen_face, kappa_, mu_, sums);
  for (std::size_t k = 0; k < 2 && !correction_.slope[k].empty(); ++k) {
    double even = 0.0;
    for (std::size_t i = 0; i < exitance_.size(); ++i) {
      even += by_exitance[i] * correction_.slope[k][i] * exitance_[i];
    }
    std::vector<double>& by_voxel = k == 0 ? gradient.log_kappa : gradient.log_mu;
    for (double& g : by_voxel) g += even / static_cast<double>(by_voxel.size());
  }
  return gradient;
}

std::vector<double> Objective::prediction() const {
  std::vector<double> corrected(exitance_.size());
  for (std::size_t i = 0; i < exitance_.size(); ++i) corrected[i] = ratio_[i] * exitance_[i];
  return corrected;
}

}  // namespace kappamu::inverse
