// The options of the fit that `kappamu fit` and `kappamu run` share.
#include "app/fit_options.h"

#include <CLI/CLI.hpp>

namespace kappamu::app {

namespace {

using pipeline::FitArguments;

inverse::HomogeneousGuess& start_of(inverse::FitOptions& fit) {
  if (!fit.start) fit.start.emplace();
  return *fit.start;
}

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
      .add_option_function<double>(
          "--weight,--lambda", [&fit](double w) { fit.weight = w; },
          "Smooth with this weight only, instead of choosing it; with --regulariser wang2008 the "
          "paper's λ")
      ->group(group);
}

}  // namespace

void add_fit_options(CLI::App& command, FitArguments& arguments, const std::string& group) {
  inverse::FitOptions& fit = arguments.stage.fit;
  fit.sensitivity_probes = pipeline::sensitivity_probes;
  fit.uncertainty.samples = pipeline::uncertainty_samples;
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

}  // namespace kappamu::app
