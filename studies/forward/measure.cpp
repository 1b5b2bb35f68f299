#include "studies/forward/measure.h"

#include <algorithm>
#include <cmath>

#include "core/processor_time.h"
#include "core/progress.h"
#include "forward/forward_model.h"
#include "studies/baseline/baseline_model.h"
#include "studies/record.h"

namespace kappamu::studies {

namespace {

std::string name_of(forward::Precision precision) {
  return precision == forward::Precision::single_precision ? "single" : "double";
}

/// What was not compared reaches no error.
double error_of(const Sample& sample) {
  return sample.error().value_or(HUGE_VAL);
}

}  // namespace

std::vector<Sample> measure_grid_solver(const Problem& problem, const std::string& device,
                                        forward::Precision precision, int patterns,
                                        const std::vector<double>& tolerances, int repetitions,
                                        std::vector<double>* fluence) {
  const auto choice = forward::make_grid_solver(problem.setup(), device, precision);
  forward::GridSolver& solver = *choice.solver;
  const Medium& medium = problem.medium();
  std::vector<double> set_up;
  solver.set_medium(medium.kappa.values(), medium.mu.values());  // compiles, allocates
  const auto b = solver.make_field(patterns);
  auto phi = solver.make_field(patterns);
  const std::vector<double> light = problem.irradiance(patterns);
  solver.light_source(light, *b);
  solver.solve(*b, *phi, {0.1, 2});
  for (int r = 0; r < repetitions; ++r) {
    const Stopwatch watch;
    solver.set_medium(medium.kappa.values(), medium.mu.values());
    set_up.push_back(watch.seconds());
  }

  const bool compared = problem.spec().compared > 0;
  std::vector<double> values;
  if (compared || fluence != nullptr) {
    values.resize(problem.setup().shape.cells() * static_cast<std::size_t>(patterns));
  }
  std::vector<Sample> samples;
  for (const double tolerance : tolerances) {
    Sample sample;
    sample.method = device == "reference" ? "reference" : "multigrid";
    sample.precision = device == "reference" ? "double" : name_of(precision);
    sample.tolerance = tolerance;
    sample.patterns = patterns;
    sample.set_up_seconds = median(set_up);
    std::vector<double> seconds;
    for (int r = 0; r < repetitions; ++r) {
      phi.reset();  // for the next one, of zeros, to take its place
      phi = solver.make_field(patterns);
      const Stopwatch watch;
      const forward::SolveReport report = solver.solve(*b, *phi, {tolerance, 400});
      seconds.push_back(watch.seconds());
      sample.iterations = report.iterations;
      sample.converged = report.termination == forward::Termination::converged;
    }
    sample.solve_seconds_per_rhs = median(seconds) / patterns;
    sample.seconds_per_rhs =
        sample.solve_seconds_per_rhs + sample.set_up_seconds / problem.spec().patterns;
    if (!values.empty()) solver.read(*phi, values);
    if (compared) {
      const Errors errors = problem.errors_of(values, patterns);
      sample.phi_error = errors.phi;
      sample.map_error = errors.maps;
    }
    samples.push_back(sample);
  }
  if (fluence != nullptr) *fluence = std::move(values);
  return samples;
}

std::vector<Sample> measure_model(const Problem& problem, const std::string& method,
                                  const std::string& device, const std::vector<double>& tolerances,
                                  double budget_seconds) {
  const auto model = baseline::make_model(method);
  forward::ForwardProblem question{problem.setup(), problem.medium(), problem.spec().patterns,
                                   problem.irradiance()};
  forward::ForwardOptions options;
  options.device = device;
  Progress progress;
  // A short run first: it compiles, and tells what a sweep costs.
  constexpr int trial_sweeps = 48;
  options.solve = {1e-12, trial_sweeps};
  model->solve(question, options, progress);
  const forward::ForwardResult trial = model->solve(question, options, progress);
  const double per_sweep = trial.seconds / std::max(1, trial.iterations);
  const int affordable = std::max(trial_sweeps, static_cast<int>(budget_seconds / per_sweep));

  std::vector<Sample> samples;
  for (const double tolerance : tolerances) {
    options.solve = {tolerance, affordable};
    const forward::ForwardResult result = model->solve(question, options, progress);
    Sample sample;
    sample.method = method;
    sample.precision = "single";
    sample.tolerance = tolerance;
    sample.patterns = problem.spec().patterns;
    sample.iterations = result.iterations;
    sample.converged = result.termination == forward::Termination::converged;
    sample.set_up_seconds = result.setup_seconds;
    sample.solve_seconds_per_rhs = result.seconds / sample.patterns;
    sample.seconds_per_rhs =
        sample.solve_seconds_per_rhs + sample.set_up_seconds / problem.spec().patterns;
    sample.map_error = problem.map_error(result.exitance, sample.patterns);
    samples.push_back(sample);
    if (!sample.converged) break;
  }
  return samples;
}

std::optional<double> seconds_at_error(const std::vector<Sample>& samples, double error) {
  std::optional<double> least;
  const auto offer = [&](double seconds) { least = least ? std::min(*least, seconds) : seconds; };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double e = error_of(samples[i]), t = samples[i].seconds_per_rhs;
    if (e <= error && (i == 0 || error_of(samples[i - 1]) <= error)) offer(t);
    if (i == 0 || e > error || error_of(samples[i - 1]) <= error) continue;
    const double before = error_of(samples[i - 1]), t_before = samples[i - 1].seconds_per_rhs;
    const double share = std::log(before / error) / std::log(before / e);
    offer(t_before * std::pow(t / t_before, share));
  }
  return least;
}

const Sample* cheapest_at_error(const std::vector<Sample>& samples, double error) {
  const Sample* best = nullptr;
  for (const Sample& sample : samples) {
    if (error_of(sample) > error) continue;
    if (best == nullptr || sample.seconds_per_rhs < best->seconds_per_rhs) best = &sample;
  }
  return best;
}

}  // namespace kappamu::studies
