// The options of the fit that `kappamu fit` and `kappamu run` share.
#include "app/fit_options.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace kappamu::app {

namespace {

inverse::HomogeneousGuess& start_of(inverse::FitOptions& fit) {
  if (!fit.start) fit.start.emplace();
  return *fit.start;
}

/// [W] 4.2.
constexpr double wang2008_lambda = 1e-5;

void add_data_term_options(CLI::App& command, FitArguments& arguments, const std::string& group) {
  inverse::DataTermOptions& data = arguments.stage.fit.data_term;
  command
      .add_option("--loss", arguments.loss,
                  "What a residual costs: gaussian (half its square), or huber or student, which "
                  "wild pixels cannot spoil")
      ->check(CLI::IsMember({"gaussian", "huber", "student"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--huber-threshold", data.huber_threshold,
                  "Of --loss huber: standard deviations beyond which a datum pulls no harder")
      ->capture_default_str()
      ->group(group);
  command.add_option("--student-freedom", data.student_freedom, "Of --loss student")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--gains", arguments.gains,
                  "Give each pattern a gain of its own, about 1 with this relative spread (0.03 "
                  "for a projector that drifts by 3 %); 0: none")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("SPREAD")
      ->capture_default_str()
      ->group(group);
}

void add_regulariser_options(CLI::App& command, FitArguments& arguments, const std::string& group) {
  inverse::FitOptions& fit = arguments.stage.fit;
  command
      .add_option("--regulariser", arguments.regulariser,
                  "h1: smooth κ and μ; huber-tv: keeps edges; wang2008: the paper's, κ alone and "
                  "data unweighted, at λ = 1e-5 unless --lambda says otherwise")
      ->check(CLI::IsMember({"h1", "huber-tv", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--edge-slope", fit.regulariser.edge_slope,
                  "Of --regulariser huber-tv: slope beyond which it is an edge, in log units per "
                  "thickness of the block")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--choose-weight", arguments.choose_weight,
                  "How far the weight is lowered on the full grid: discrepancy (to the noise "
                  "level), l-curve, or held-out (least chi2 under the light of --hold-out)")
      ->check(CLI::IsMember({"discrepancy", "l-curve", "held-out"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option_function<double>(
          "--weight,--lambda", [&fit](double w) { fit.weight = w; },
          "Smooth with this weight only, instead of choosing it; with --regulariser wang2008 the "
          "paper's λ")
      ->group(group);
}

}  // namespace

void add_fit_options(CLI::App& command, FitArguments& arguments, const std::string& group) {
  inverse::FitOptions& fit = arguments.stage.fit;
  fit.sensitivity_probes = sensitivity_probes;
  fit.uncertainty.samples = uncertainty_samples;
  const auto number = [&](const std::string& name, double& value, const std::string& text) {
    command.add_option(name, value, text)->capture_default_str()->group(group);
  };
  command
      .add_option("--hold-out", arguments.stage.hold_out,
                  "Patterns of the input kept out of the fit to judge it by: auto (those captured "
                  "for validation, else one of every 16), none, a count, or numbers from 0 with "
                  "commas (5,10)")
      ->type_name("PATTERNS")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--model", arguments.model,
                  "homogeneous, layered (even layers across the light), volume, or auto: the "
                  "simplest that the data do not reject, channel by channel")
      ->check(CLI::IsMember({"auto", "homogeneous", "layered", "volume"}))
      ->capture_default_str()
      ->group(group);
  auto* kappa = command.add_option_function<double>(
      "--start-kappa", [&fit](double k) { start_of(fit).kappa = k; },
      "Let the search for the homogeneous start try this kappa [mm] as well");
  auto* mu = command.add_option_function<double>(
      "--start-mu", [&fit](double m) { start_of(fit).mu = m; }, "and of this mu [1/mm]");
  kappa->needs(mu)->group(group);
  mu->needs(kappa)->group(group);
  command
      .add_option(
          "--optimiser", arguments.optimiser,
          "lbfgs; gauss-newton: matrix-free, by truncated conjugate gradients; or wang2008: "
          "Polak-Ribière conjugate gradients with golden-section search, the paper's, many times "
          "slower")
      ->check(CLI::IsMember({"lbfgs", "gauss-newton", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--convention", arguments.convention,
                  "physical, or wang2008: the paper's boundary condition, C = 2.1489")
      ->check(CLI::IsMember({"physical", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--precision", arguments.precision, "Of the solver: single, or double (slower)")
      ->check(CLI::IsMember({"single", "double"}))
      ->capture_default_str()
      ->group(group);
  add_data_term_options(command, arguments, group);
  add_regulariser_options(command, arguments, group);
  number("--target-chi2", fit.target_chi2,
         "Lower the weight until chi2 per value is this; above 1 for a smoother volume");
  number("--model-error", fit.model_error.relative,
         "Error of the model relative to each value, added to its standard deviation");
  number("--model-error-floor", fit.model_error.of_maximum,
         "The same relative to the largest value of each pattern");
  number("--stage-tolerance", fit.stage_tolerance,
         "Relative decrease of the objective per step below which a weight is done");
  number("--final-tolerance", fit.final_tolerance,
         "The same for the last weight, where the fit ends");
  command.add_option("--stage-steps", fit.stage_steps, "Most steps at one weight")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--levels", fit.max_levels,
                  "Grids from coarse to fine; 1 fits on the full grid at once")
      ->capture_default_str()
      ->group(group);
  command
      .add_option(
          "--uncertainty", fit.uncertainty.samples,
          "Samples that tell the standard deviations of the volumes; S of them cost 24 S + 8 "
          "batched solves; 0 = none")
      ->capture_default_str()
      ->group(group);
  command
      .add_flag("--no-grid-correction", arguments.no_grid_correction,
                "Do not correct for the fitted grid's own error")
      ->group(group);
}

namespace {

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
                              {"gain_spread", o.data_term.gain_spread.value_or(0.0)},
                              {"regulariser", inverse::to_string(o.regulariser.kind)},
                              {"edge_slope", o.regulariser.edge_slope},
                              {"choose_weight", inverse::to_string(o.weight_rule)},
                              {"held_out_relief", o.held_out_relief},
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

FitStageOptions resolve(const FitArguments& arguments, const Globals& globals) {
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
  using inverse::WeightRule;
  if (arguments.loss == "huber") fit.data_term.loss = Loss::huber;
  if (arguments.loss == "student") fit.data_term.loss = Loss::student;
  if (arguments.gains > 0.0) fit.data_term.gain_spread = arguments.gains;
  if (arguments.regulariser == "huber-tv") fit.regulariser.kind = RegulariserKind::huber_tv;
  if (arguments.regulariser == "wang2008") {
    fit.regulariser.kind = RegulariserKind::wang2008;
    if (!fit.weight) fit.weight = wang2008_lambda;
  }
  if (arguments.choose_weight == "l-curve") fit.weight_rule = WeightRule::l_curve;
  if (arguments.choose_weight == "held-out") fit.weight_rule = WeightRule::held_out;
  if (arguments.convention == "wang2008") fit.convention = forward::Convention::wang2008;
  if (arguments.precision == "double") {
    fit.backend.precision = forward::Precision::double_precision;
  }
  fit.correct_grid = !arguments.no_grid_correction;
  fit.backend.device = globals.device;
  fit.seed = globals.seed;
  inverse::validate(fit);
  return stage;
}

}  // namespace kappamu::app
