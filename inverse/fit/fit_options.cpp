// What a fit may be asked for, and the names of how it ends.
#include <string>

#include "core/error.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

namespace {

void require(bool holds, const std::string& sentence) {
  if (!holds) throw InputError("fit options: " + sentence);
}

}  // namespace

void validate(const FitOptions& o) {
  require(!o.start || (o.start->kappa > 0.0 && o.start->mu > 0.0),
          "the start needs a positive kappa and a positive mu");
  validate(o.data_term);
  require(
      o.optimiser.method != Method::gauss_newton ||
          (o.regulariser.kind != RegulariserKind::wang2008 && o.data_term.loss == Loss::gaussian),
      "the gauss-newton optimiser knows the regularisers h1 and huber-tv and the gaussian loss; "
      "choose lbfgs for others");
  require(o.regulariser.edge_slope > 0.0, "edge_slope must be positive");
  require(!o.weight || *o.weight >= 0.0, "weight must not be negative");
  require(o.first_weight > 0.0, "first_weight must be positive");
  require(o.last_weight > 0.0 && o.last_weight <= o.first_weight,
          "last_weight must be positive and at most first_weight");
  require(o.weight_factor > 0.0 && o.weight_factor < 1.0, "weight_factor must lie in (0, 1)");
  require(o.restart_steps >= 0.0, "restart_steps must not be negative");
  require(o.target_chi2 > 0.0, "target_chi2 must be positive");
  require(o.stagnation >= 0.0 && o.stagnation < 1.0, "stagnation must lie in [0, 1)");
  require(o.stage_tolerance > 0.0 && o.stage_tolerance < 1.0, "stage_tolerance must lie in (0, 1)");
  require(o.final_tolerance > 0.0, "final_tolerance must be positive");
  require(o.stage_steps >= 1, "stage_steps must be at least 1");
  require(o.max_levels >= 1, "max_levels must be at least 1");
  require(o.model_error.relative >= 0.0 && o.model_error.of_maximum >= 0.0 &&
              o.coarse_model_error.relative >= 0.0 && o.coarse_model_error.of_maximum >= 0.0,
          "model errors must not be negative");
  require(o.smooth_length > 0.0, "smooth_length must be positive");
  require(o.anchor_length > 0.0, "anchor_length must be positive");
  require(o.sensitivity_probes >= 0, "sensitivity_probes must not be negative");
  validate(o.uncertainty);
  require(o.optimiser.memory >= 1, "memory must be at least 1 pair");
  require(o.optimiser.first_step > 0.0 && o.optimiser.longest_step > 0.0,
          "step bounds must be positive");
  require(o.optimiser.max_backtracks >= 1, "max_backtracks must be at least 1");
  require(o.optimiser.golden_tolerance > 0.0, "golden_tolerance must be positive");
  require(o.optimiser.newton_iterations >= 1, "newton_iterations must be at least 1");
  require(o.optimiser.newton_forcing > 0.0 && o.optimiser.newton_forcing < 1.0,
          "newton_forcing must lie in (0, 1)");
  require(o.backend.batch >= 1, "batch must be at least 1 pattern");
  require(o.backend.refined_tolerance > 0.0, "refined_tolerance must be positive");
  require(o.backend.refined_memory_mb > 0.0, "refined_memory_mb must be positive");
  require(o.backend.solve.tolerance > 0.0 && o.backend.solve.max_iterations >= 1,
          "the solver's tolerance must be positive and max_iterations at least 1");
}

std::string to_string(FitStatus status) {
  switch (status) {
    case FitStatus::converged:
      return "converged";
    case FitStatus::above_noise:
      return "above_noise";
    default:
      return "ran_out";
  }
}

}  // namespace kappamu::inverse
