#include "inverse/problem/objective.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

using forward::SolveReport;
using forward::Termination;

bool within_range(const CoefficientPair& fields) {
  const auto ok = [](double x) { return std::abs(x) <= max_log_coefficient; };  // false for NaN
  return for_all(fields.log_mu.size(),
                 [&](std::size_t i) { return ok(fields.log_kappa[i]) && ok(fields.log_mu[i]); });
}

/// Element by element.
std::vector<double> products(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for_pieces(a.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) result[i] = a[i] * b[i];
  });
  return result;
}

/// Voxels times iterations of a batch of `part` out of `patterns`.
double cost(const forward::DiffusionOperator& op, const SolveReport& report, int part,
            int patterns) {
  return static_cast<double>(op.space().cells()) * report.iterations * part / patterns;
}

/// Patterns [begin, end) of an array [M][...] of `size` values each.
template <class Values>
auto patterns_of(Values& values, int begin, int end, std::size_t size) {
  return std::span(values).subspan(static_cast<std::size_t>(begin) * size,
                                   static_cast<std::size_t>(end - begin) * size);
}

}  // namespace

forward::MadeOperator Backend::make(const forward::GridSetup& setup,
                                    const forward::SeenFaces& seen) const {
  return (operators ? operators : forward::block_operators())->make(setup, seen, device, precision);
}

Refinement refine(const Problem& problem) {
  Refinement refinement;
  refinement.setup = problem.setup;
  refinement.setup.shape = problem.setup.shape.refined(2);
  refinement.irradiance =
      split_face(problem.irradiance, problem.lit_shape(),
                 face_shape(refinement.setup.shape, problem.setup.lit_face), 2, problem.patterns);
  return refinement;
}

void solve_batches(const forward::DiffusionOperator& op, int patterns, const BatchedSolve& solve,
                   const std::function<void(int, forward::BatchField&)>& load,
                   const std::function<void(int, const forward::BatchField&)>& use) {
  for (int begin = 0; begin < patterns; begin += solve.batch) {
    const int count = std::min(solve.batch, patterns - begin);
    const auto b = op.make_field(count);
    const auto phi = op.make_field(count);
    load(begin, *b);
    if (solve.guess) solve.guess(begin, *phi);
    const SolveReport report = op.solve(*b, *phi, solve.options);
    if (report.termination == Termination::failed) {
      throw InputError("the diffusion solver failed: " + report.message);
    }
    if (solve.voxel_iterations != nullptr) {
      *solve.voxel_iterations += cost(op, report, count, patterns);
    }
    use(begin, *phi);
  }
}

std::vector<double> solve_exitance(const forward::DiffusionOperator& op,
                                   const std::vector<double>& light, int patterns,
                                   const BatchedSolve& solve) {
  std::vector<double> exitance(op.exitance_size() * static_cast<std::size_t>(patterns));
  const auto lit = [&](int first, int count) {
    return patterns_of(light, first, first + count, op.light_size());
  };
  solve_batches(
      op, patterns, solve,
      [&](int first, forward::BatchField& b) { op.load(lit(first, b.patterns()), b); },
      [&](int first, const forward::BatchField& phi) {
        op.exitance(phi, lit(first, phi.patterns()),
                    patterns_of(exitance, first, first + phi.patterns(), op.exitance_size()));
      });
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
      views_(problem_.views()),
      light_(views_.of_lights(problem_.irradiance)),
      backend_(std::move(backend)),
      derivative_solve_(backend_.solve),
      data_options_(data_term) {
  if (!problem_.lateral.empty()) lit_.emplace(problem_);
  forward::MadeOperator made = backend_.make(problem_.setup, views_.faces());
  operator_ = std::move(made.op);
  warning_ = std::move(made.warning);
  stated_weight_ = problem_.weight;
  correction_.ratio.assign(problem_.data.size(), 1.0);
  ratio_ = correction_.ratio;
  all_on_device_ = belong_on_device(0.0);
}

void Objective::set_derivative_tolerance(double tolerance) {
  derivative_solve_.tolerance = tolerance;
}

/// Values [L][...] of the patterns of a batch, `size` each.
template <class Values>
auto Objective::of_batch(Values& values, std::size_t part, std::size_t size) const {
  const int begin = static_cast<int>(part) * backend_.batch;
  return patterns_of(values, begin, std::min(begin + backend_.batch, views_.lights()), size);
}

/// False where there is no solution to speak of. Solves nothing where it has just solved.
bool Objective::solve_forward(const CoefficientPair& fields) {
  if (!fluence_.empty() && fields == fields_) return true;
  fluence_.clear();
  if (!within_range(fields)) return false;
  fields_ = fields;
  device_means_.reset();
  if (all_on_device_) {
    if (!solve_on_device(device_data().upload(fields))) return false;
    see_device();
    return true;
  }
  operator_->set_medium(exponential(fields.log_kappa), exponential(fields.log_mu));
  leaving_.resize(operator_->exitance_size() * static_cast<std::size_t>(views_.lights()));
  const bool solved = solve_lights(
      [&](std::size_t part, forward::BatchField& b) {
        operator_->load(of_batch(light_, part, operator_->light_size()), b);
      },
      [&](std::size_t part, const forward::BatchField& phi) {
        operator_->exitance(phi, of_batch(light_, part, operator_->light_size()),
                            of_batch(leaving_, part, operator_->exitance_size()));
      });
  if (solved) see();
  return solved;
}

/// Of the operator's medium; leave(batch, φ) has what leaves.
bool Objective::solve_lights(const LoadBatch& load, const UseBatch& leave) {
  ++solves_.forward;
  const int lights = views_.lights();
  for (int begin = 0; begin < lights; begin += backend_.batch) {
    const int end = std::min(begin + backend_.batch, lights);
    const std::size_t part = fluence_.size();
    const auto b = operator_->make_field(end - begin);
    auto phi = operator_->make_field(end - begin);
    load(part, *b);
    // From zero, never from the last solution: equal fits end in equal bits.
    const SolveReport report = operator_->solve(*b, *phi, backend_.solve);
    solves_.voxel_iterations += cost(*operator_, report, end - begin, lights);
    if (report.termination == Termination::failed) {
      fluence_.clear();
      return false;
    }
    leave(part, *phi);
    fluence_.push_back(std::move(phi));
  }
  return true;
}

/// The pictures of leaving_, and r there.
void Objective::see() {
  exitance_ = views_.pictures(leaving_);
  correct();
  seen_here_ = true;
}

/// A batch solved by the last value().
forward::SolvedBatch Objective::batch(std::size_t part) const {
  return {*fluence_[part], of_batch(light_, part, operator_->light_size()),
          of_batch(leaving_, part, operator_->exitance_size())};
}

double Objective::misfit() {
  data_term_ = evaluate(problem_, prediction(), data_options_);
  return data_term_.value;
}

double Objective::value(const CoefficientPair& fields) {
  return solve_forward(fields) ? misfit() : std::numeric_limits<double>::infinity();
}

CoefficientPair Objective::gradient() {
  return adjoint(by_exitance());
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
  std::vector<double> change;
  change.reserve(leaving_.size());
  for (std::size_t part = 0; part < fluence_.size(); ++part) {
    const forward::SolvedBatch at = batch(part);
    const int patterns = at.phi.patterns();
    const auto b = operator_->make_field(patterns);
    const auto field = operator_->make_field(patterns);
    std::vector<double> direct(at.exitance.size());
    operator_->linearise(at, direction, *b, direct);
    const SolveReport report = operator_->solve(*b, *field, derivative_solve_);
    if (report.termination == Termination::failed) {
      throw InputError("the linearised diffusion solve failed: " + report.message);
    }
    solves_.voxel_iterations += cost(*operator_, report, patterns, views_.lights());
    const std::vector<double> dark(at.light.size(), 0.0);  // light is none of δφ's doing
    std::vector<double> by_fluence(at.exitance.size());
    operator_->exitance(*field, dark, by_fluence);
    std::transform(direct.begin(), direct.end(), by_fluence.begin(), std::back_inserter(change),
                   std::plus<>());
  }
  change = views_.pictures(std::move(change));
  const std::array<double, 2> even = means(direction);
  for (std::size_t i = 0; i < change.size(); ++i) {
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

/// A λ = b as loaded for each batch, and what add(batch, λ) makes of it.
void Objective::solve_adjoint(const LoadBatch& load, const UseBatch& add) {
  check(!fluence_.empty(), "a gradient needs the fluence of a successful value()");
  ++solves_.adjoint;
  for (std::size_t part = 0; part < fluence_.size(); ++part) {
    const int patterns = fluence_[part]->patterns();
    const auto b = operator_->make_field(patterns);
    const auto lambda = operator_->make_field(patterns);
    load(part, *b);
    const SolveReport report = operator_->solve(*b, *lambda, derivative_solve_);
    if (report.termination == Termination::failed) {
      throw InputError("the adjoint diffusion solve failed: " + report.message);
    }
    solves_.voxel_iterations += cost(*operator_, report, patterns, views_.lights());
    add(part, *lambda);
  }
}

/// By log κ and log μ of every voxel, from r, which goes as their means do.
std::array<double, 2> Objective::even_gradient(const std::vector<double>& by_exitance) const {
  std::array<double, 2> even{};
  for (std::size_t k = 0; k < 2 && !correction_.slope[k].empty(); ++k) {
    for (std::size_t i = 0; i < exitance_.size(); ++i) {
      even[k] += by_exitance[i] * correction_.slope[k][i] * exitance_[i];
    }
    even[k] /= static_cast<double>(space().cells());
  }
  return even;
}

CoefficientPair Objective::adjoint(const std::vector<double>& by_exitance) {
  const std::size_t cells = space().cells();
  CoefficientPair gradient;
  const std::vector<double> by_leaving = views_.exitance(by_exitance);
  if (all_on_device_) {
    device_data().set_by_exitance(by_leaving);
    const device::Buffer sum = device_data().zeros(2 * cells);
    adjoint_on_device(sum);
    gradient = device_data().download(sum, cells);
  } else {
    gradient = {std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)};
    const auto weights = [&](std::size_t part) {
      return of_batch(by_leaving, part, operator_->exitance_size());
    };
    solve_adjoint([&](std::size_t part,
                      forward::BatchField& b) { operator_->exitance_transpose(weights(part), b); },
                  [&](std::size_t part, const forward::BatchField& lambda) {
                    operator_->add_gradient(batch(part), lambda, weights(part), gradient);
                  });
  }
  const std::array<double, 2> even = even_gradient(by_exitance);
  for (std::size_t k = 0; k < 2 && !correction_.slope[k].empty(); ++k) {
    for (double& g : k == 0 ? gradient.log_kappa : gradient.log_mu) g += even[k];
  }
  return gradient;
}

/// Derivatives of the data term by M.
std::vector<double> Objective::by_exitance() const {
  return products(data_term_.by_prediction, ratio_);
}

std::vector<double> Objective::prediction() const {
  return products(ratio_, exitance_);
}

}  // namespace kappamu::inverse
