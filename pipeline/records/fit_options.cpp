#include "pipeline/records/fit_options.h"

#include <nlohmann/json.hpp>

namespace kappamu::pipeline {

namespace {

/// [W] 4.2.
constexpr double wang2008_lambda = 1e-5;

const char* name_of(inverse::Coordinates coordinates) {
  switch (coordinates) {
    case inverse::Coordinates::voxels:
      return "voxels";
    case inverse::Coordinates::smooth:
      return "smooth";
    default:
      return "informed";
  }
}

const char* name_of(inverse::Method method) {
  switch (method) {
    case inverse::Method::gauss_newton:
      return "gauss-newton";
    case inverse::Method::wang2008:
      return "wang2008";
    default:
      return "lbfgs";
  }
}

nlohmann::ordered_json to_json(const FitStageOptions& options) {
  const inverse::FitOptions& o = options.fit;
  const bool physical = o.convention == forward::Convention::physical;
  const bool twofold = o.backend.precision == forward::Precision::double_precision;
  nlohmann::ordered_json json{{"model", to_string(o.model)},
                              {"start_kappa", nullptr},
                              {"start_mu", nullptr},
                              {"optimiser", name_of(o.optimiser.method)},
                              {"optimiser_memory", o.optimiser.memory},
                              {"optimiser_first_step", o.optimiser.first_step},
                              {"optimiser_longest_step", o.optimiser.longest_step},
                              {"optimiser_max_backtracks", o.optimiser.max_backtracks},
                              {"optimiser_golden_tolerance", o.optimiser.golden_tolerance},
                              {"optimiser_newton_iterations", o.optimiser.newton_iterations},
                              {"optimiser_newton_forcing", o.optimiser.newton_forcing},
                              {"coordinates", name_of(o.coordinates)},
                              {"loss", inverse::to_string(o.data_term.loss)},
                              {"huber_threshold", o.data_term.huber_threshold},
                              {"student_freedom", o.data_term.student_freedom},
                              {"regulariser", inverse::to_string(o.regulariser.kind)},
                              {"edge_slope", o.regulariser.edge_slope},
                              {"convention", physical ? "physical" : "wang2008"},
                              {"weight", nullptr},
                              {"first_weight", o.first_weight},
                              {"last_weight", o.last_weight},
                              {"weight_factor", o.weight_factor},
                              {"restart_steps", o.restart_steps},
                              {"target_chi2", o.target_chi2},
                              {"stagnation", o.stagnation},
                              {"stage_tolerance", o.stage_tolerance},
                              {"final_tolerance", o.final_tolerance},
                              {"stage_steps", o.stage_steps},
                              {"max_levels", o.max_levels},
                              {"correct_grid", o.correct_grid},
                              {"model_error_relative", o.model_error.relative},
                              {"model_error_of_maximum", o.model_error.of_maximum},
                              {"coarse_model_error_relative", o.coarse_model_error.relative},
                              {"coarse_model_error_of_maximum", o.coarse_model_error.of_maximum},
                              {"smooth_length", o.smooth_length},
                              {"anchor_length", o.anchor_length},
                              {"metric_probes", o.metric_probes},
                              {"sensitivity_probes", o.sensitivity_probes},
                              {"uncertainty_samples", o.uncertainty.samples},
                              {"uncertainty_steps", o.uncertainty.steps},
                              {"uncertainty_probes", o.uncertainty.probes},
                              {"uncertainty_pooling", o.uncertainty.pooling},
                              {"seed", o.seed},
                              {"device", o.backend.device},
                              {"precision", twofold ? "double" : "single"},
                              {"solver_tolerance", o.backend.solve.tolerance},
                              {"solver_max_iterations", o.backend.solve.max_iterations},
                              {"batch", o.backend.batch},
                              {"refined_tolerance", o.backend.refined_tolerance},
                              {"refined_memory_mb", o.backend.refined_memory_mb},
                              {"channels", options.channels},
                              {"hold_out", options.hold_out},
                              {"continue_from", nullptr}};
  if (options.continue_from) json["continue_from"] = options.continue_from->string();
  if (o.weight) json["weight"] = *o.weight;
  if (o.start) {
    json["start_kappa"] = o.start->kappa;
    json["start_mu"] = o.start->mu;
  }
  return json;
}

}  // namespace

std::string options_json(const FitStageOptions& options) {
  return to_json(options).dump();
}

std::map<std::string, std::string> options_by_name(const FitStageOptions& options) {
  std::map<std::string, std::string> by_name;
  const nlohmann::ordered_json json = to_json(options);
  for (const auto& [name, value] : json.items()) {
    by_name[name] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return by_name;
}

FitStageOptions resolve(const FitArguments& arguments, const std::string& device,
                        std::uint64_t seed) {
  FitStageOptions stage = arguments.stage;
  inverse::FitOptions& fit = stage.fit;
  fit.model = inverse::model_of(arguments.model);
  if (arguments.optimiser == "gauss-newton") fit.optimiser.method = inverse::Method::gauss_newton;
  if (arguments.optimiser == "wang2008") {
    fit.optimiser.method = inverse::Method::wang2008;
    fit.coordinates = inverse::Coordinates::voxels;  // as [W] moves, without a metric
  }
  using inverse::Loss;
  using inverse::RegulariserKind;
  if (arguments.loss == "huber") fit.data_term.loss = Loss::huber;
  if (arguments.loss == "student") fit.data_term.loss = Loss::student;
  if (arguments.regulariser == "huber-tv") fit.regulariser.kind = RegulariserKind::huber_tv;
  if (arguments.regulariser == "wang2008") {
    fit.regulariser.kind = RegulariserKind::wang2008;
    if (!fit.weight) fit.weight = wang2008_lambda;
  }
  if (arguments.convention == "wang2008") fit.convention = forward::Convention::wang2008;
  if (arguments.precision == "double") {
    fit.backend.precision = forward::Precision::double_precision;
  }
  fit.correct_grid = !arguments.no_grid_correction;
  fit.backend.device = device;
  fit.seed = seed;
  inverse::validate(fit);
  return stage;
}

}  // namespace kappamu::pipeline
