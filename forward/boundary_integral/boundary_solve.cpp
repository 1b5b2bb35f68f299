#include "forward/boundary_integral/boundary_solve.h"

#include <cmath>

#include "core/processor_time.h"
#include "forward/boundary_integral/gmres.h"
#include "forward/boundary_integral/layer_sum.h"
#include "forward/light_entry.h"

namespace kappamu::forward::boundary_integral {

namespace {

using Eigen::VectorXd;

/// What sums and residuals may leave, of the accuracy asked for: the equation's inverse is of norm
/// 2 and more.
constexpr double margin = 0.3;

}  // namespace

std::vector<double> boundary_source(const ObjectLight& light, const BoundaryConstants& constants) {
  std::vector<double> q = light.diffuse;
  for (double& value : q) value *= diffuse_transmittance(constants) * constants.q_per_entering();
  return q;
}

BoundaryAnswer solve_boundary(const ObjectProblem& problem, const BoundaryConstants& constants,
                              const std::vector<Panel>& panels, double accuracy) {
  const Stopwatch watch;
  const Coefficients medium = problem.medium.smallest();
  const double decay = std::sqrt(medium.mu / medium.kappa);
  const double robin = 1.0 / (2.0 * constants.A * medium.kappa);
  const int order = sum_order(margin * accuracy);
  const auto count = static_cast<Eigen::Index>(panels.size());
  BoundaryAnswer answer;
  std::vector<VectorXd> right;
  for (const ObjectLight& light : problem.lights) {
    const BeamSource source = beam_source(problem, light.beams, panels);
    answer.beams.push_back(source.powers);
    right.push_back(beam_potentials(source, panels, medium, order));
  }
  bool diffuse = false;
  for (const ObjectLight& light : problem.lights) diffuse = diffuse || !light.diffuse.empty();
  if (diffuse) {
    const FastSum from_source = layer_sum(panels, {decay, robin, 0.0, order});
    for (std::size_t l = 0; l < right.size(); ++l) {
      if (problem.lights[l].diffuse.empty()) continue;
      const std::vector<double> q = boundary_source(problem.lights[l], constants);
      VectorXd on_panels(count);
      for (Eigen::Index k = 0; k < count; ++k) {
        on_panels[k] = q[static_cast<std::size_t>(panels[static_cast<std::size_t>(k)].sample)];
      }
      right[l] += from_source(on_panels);
    }
  }
  const FastSum layers = layer_sum(panels, {decay, robin, 1.0, order});
  answer.bytes = layers.bytes();
  answer.setup_seconds = watch.seconds();
  const auto equation = [&](const VectorXd& u) -> VectorXd { return 0.5 * u + layers(u); };
  GmresLimits limits;
  limits.tolerance = margin * accuracy;
  for (const VectorXd& b : right) {
    VectorXd fluence = VectorXd::Zero(count);
    const GmresReport report = gmres(equation, b, limits, fluence);
    answer.iterations = std::max(answer.iterations, report.iterations);
    answer.converged = answer.converged && report.converged;
    answer.fluence.push_back(std::move(fluence));
  }
  answer.seconds = watch.seconds() - answer.setup_seconds;
  return answer;
}

}  // namespace kappamu::forward::boundary_integral
