#include "forward/boundary_integral/boundary_integral_model.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/mesh/surface_norm.h"
#include "core/process_memory.h"
#include "core/shown_text.h"
#include "forward/bodies.h"
#include "forward/boundary_integral/boundary_solve.h"
#include "forward/boundary_integral/layer_sum.h"
#include "forward/boundary_integral/panels/sliver.h"
#include "forward/light_entry.h"
#include "forward/object_verdict.h"

namespace kappamu::forward {

namespace {

using namespace boundary_integral;

/// Sums and linear systems are this much more accurate than the tolerance, within these limits.
constexpr double solved_better = 0.02, most_accurate = 1e-6, least_accurate = 1e-4;
/// Memory of a panel with its share of the sum's matrices [bytes], measured.
constexpr double bytes_per_panel = 9000.0;
constexpr double usable_memory = 0.7;

/// The answer for one body on its last panels.
struct BodyAnswer {
  std::vector<std::vector<double>> exitance;  ///< [light][triangle]
  std::vector<ObjectBalance> balance;
  /// Per light, the 2-norm of what the last split changed: 3 times the error where it falls as 1/N,
  /// the error itself where it falls with the panels' size, at edges of light.
  std::vector<double> error;
  std::size_t panels = 0;
  int iterations = 0;
  double setup_seconds = 0.0, seconds = 0.0;
  bool within_tolerance = false, converged = true;
};

class BodySolve {
 public:
  BodySolve(const ObjectProblem& problem, const ObjectOptions& options, Progress& progress)
      : problem_(problem), options_(options), progress_(progress) {
    const double memory = usable_memory * main_memory() / bytes_per_panel;
    most_panels_ = options.max_elements ? static_cast<std::size_t>(*options.max_elements)
                                        : static_cast<std::size_t>(memory);
  }

  BodyAnswer run() {
    std::vector<Panel> panels = fitted_to_boxes(panels_of(problem_.mesh));
    BodyAnswer best;
    for (bool first = true;; first = false) {
      std::vector<Panel> quarters;
      for (const Panel& panel : panels) {
        const auto parts = split(panel);
        quarters.insert(quarters.end(), parts.begin(), parts.end());
      }
      const std::vector<Panel> coarse = std::exchange(panels, fitted_to_boxes(std::move(quarters)));
      if (panels.size() > most_panels_) {
        if (first) refuse(panels.size());
        return best;
      }
      if (first) best = answer(coarse);
      BodyAnswer finer = answer(panels);
      finer.setup_seconds += best.setup_seconds;
      finer.seconds += best.seconds;
      double worst = 0.0;
      const std::vector<double> dark(problem_.surface.size(), 0.0);
      for (std::size_t l = 0; l < finer.exitance.size(); ++l) {
        finer.error.push_back(
            surface_difference(problem_.surface, finer.exitance[l], best.exitance[l]));
        const double size = surface_difference(problem_.surface, finer.exitance[l], dark);
        if (size > 0.0) worst = std::max(worst, finer.error.back() / size);
      }
      finer.within_tolerance = worst <= options_.tolerance;
      best = std::move(finer);
      report(worst, best.panels);
      if (best.within_tolerance) return best;
    }
  }

 private:
  BodyAnswer answer(const std::vector<Panel>& panels) const {
    const BoundaryAnswer solved = solve_boundary(
        problem_, constants_, panels,
        std::clamp(solved_better * options_.tolerance, most_accurate, least_accurate));
    const Surface& surface = problem_.surface;
    BodyAnswer result;
    result.panels = panels.size();
    result.iterations = solved.iterations;
    result.converged = solved.converged;
    result.setup_seconds = solved.setup_seconds;
    result.seconds = solved.seconds;
    for (std::size_t l = 0; l < solved.fluence.size(); ++l) {
      std::vector<double> exitance(surface.size(), 0.0);  // first ∫ φ dA
      for (std::size_t k = 0; k < panels.size(); ++k) {
        exitance[static_cast<std::size_t>(panels[k].sample)] +=
            panels[k].area * solved.fluence[l][static_cast<Eigen::Index>(k)];
      }
      const ObjectLight& light = problem_.lights[l];
      const std::vector<double> q = boundary_source(light, constants_);
      ObjectBalance balance;
      balance.entering = solved.beams[l].entering;
      balance.unscattered = solved.beams[l].unscattered;
      for (std::size_t t = 0; t < surface.size(); ++t) {
        double& value = exitance[t];
        value /= surface.area[t];
        if (!light.diffuse.empty()) value -= q[t];
        value /= 2.0 * constants_.A;
        if (!light.diffuse.empty()) {
          const double enters = diffuse_transmittance(constants_) * light.diffuse[t];
          value += enters;
          balance.entering += enters * surface.area[t];
        }
        balance.exiting += value * surface.area[t];
      }
      balance.absorbed = balance.entering - balance.unscattered - balance.exiting;
      result.exitance.push_back(std::move(exitance));
      result.balance.push_back(balance);
    }
    return result;
  }

  void report(double worst, std::size_t panels) const {
    progress_.update("boundary_integral",
                     std::min(1.0, options_.tolerance / std::max(worst, 1e-300)),
                     formatted("%zu panels, error %g", panels, worst));
  }

  [[noreturn]] void refuse(std::size_t panels) const {
    throw InputError("the object's surface asks for at least " + std::to_string(panels) +
                     " panels (" + gigabytes(bytes_per_panel * static_cast<double>(panels)) +
                     ") but " + std::to_string(most_panels_) +
                     (options_.max_elements ? " are allowed; raise max_elements"
                                            : " fit this machine's memory") +
                     " or simplify the mesh");
  }

  const ObjectProblem& problem_;
  const ObjectOptions& options_;
  Progress& progress_;
  const BoundaryConstants constants_ = boundary_constants(problem_.eta);
  std::size_t most_panels_ = 0;
};

}  // namespace

ObjectResult BoundaryIntegralModel::solve(const ObjectProblem& problem,
                                          const ObjectOptions& options, Progress& progress) {
  check_problem(problem, options);
  if (!problem.medium.homogeneous()) {
    throw InputError(
        "model boundary_integral needs the same kappa and mu everywhere; use model embedded for a "
        "measured volume");
  }
  refuse_slivers(problem.mesh);
  const std::size_t samples = problem.surface.size(), lights = problem.lights.size();
  ObjectResult result;
  result.exitance.assign(lights * samples, 0.0);
  result.error_estimate.assign(lights, 0.0);
  result.balance.resize(lights);
  Ended ended;
  for (const Body& body : bodies(problem.mesh, problem.rays)) {
    std::vector<int> local(samples, -1);
    for (std::size_t t = 0; t < body.triangle.size(); ++t) {
      local[static_cast<std::size_t>(body.triangle[t])] = static_cast<int>(t);
    }
    const Surface surface = surface_of(body.mesh);
    const std::vector<ObjectLight> own = lights_of(body, local, problem.lights);
    const BodyRays rays(problem.rays, std::move(local));
    const ObjectProblem part{body.mesh, surface, rays, problem.medium, problem.eta, own};
    const BodyAnswer answer = BodySolve(part, options, progress).run();
    for (std::size_t l = 0; l < lights; ++l) {
      for (std::size_t t = 0; t < body.triangle.size(); ++t) {
        result.exitance[l * samples + static_cast<std::size_t>(body.triangle[t])] =
            answer.exitance[l][t];
      }
      result.error_estimate[l] += answer.error[l] * answer.error[l];
      result.balance[l].entering += answer.balance[l].entering;
      result.balance[l].unscattered += answer.balance[l].unscattered;
      result.balance[l].exiting += answer.balance[l].exiting;
      result.balance[l].absorbed += answer.balance[l].absorbed;
    }
    result.elements += answer.panels;
    result.iterations = std::max(result.iterations, answer.iterations);
    result.setup_seconds += answer.setup_seconds;
    result.seconds += answer.seconds;
    ended.within_tolerance = ended.within_tolerance && answer.within_tolerance;
    ended.solved = ended.solved && answer.converged;
  }
  conclude(problem.surface, ended, "panels", result);
  return result;
}

ModelDescription boundary_integral_model() {
  return {.name = "boundary_integral",
          .text = "Diffusion by integral equations on the surface, with fast summation.",
          .limits = "Only homogeneous materials; diffusion errs as with embedded.",
          .can = {.voids = true, .several_bodies = true, .inner_light = true},
          .make = [] { return std::make_unique<BoundaryIntegralModel>(); },
          .errs_by = &measured("embedded").error};
}

}  // namespace kappamu::forward
