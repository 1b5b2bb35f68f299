// Every option of a fit, once: name, group, place on the command line, unit, bounds and one
// sentence. Command line, records, checkpoint fingerprints, --continue and the table in
// docs/reference/fit-options.md are visitors of describe().
//
// A visitor is called with (Option, value), and with (Option, value, names) for an enumerator
// (core/names.h); `value` is a double, int, bool, std::uint64_t, std::string or
// std::optional<double>, const where the options are. The structured bindings below name every
// field: one more in a struct does not compile until it is described here.
#pragma once

#include <array>

#include "core/names.h"
#include "core/options/options.h"
#include "inverse/fit/fit_options.h"

namespace kappamu::inverse {

/// The headings, in the order they are shown.
inline constexpr std::array<const char*, 5> option_groups{"Data", "Regulariser", "Path", "Solver",
                                                          "Uncertainty"};

inline constexpr Names<forward::Convention, 2> convention_names{
    {{"physical", forward::Convention::physical}, {"wang2008", forward::Convention::wang2008}}};
inline constexpr Names<Physics, 3> physics_names{{{"diffusion", Physics::diffusion},
                                                  {"transport", Physics::transport},
                                                  {"auto", Physics::automatic}}};
inline constexpr Names<forward::Precision, 2> precision_names{
    {{"single", forward::Precision::single_precision},
     {"double", forward::Precision::double_precision}}};

namespace description {

template <class Data, class Visitor>
void data(Data& options, Visitor& visit) {
  constexpr const char* group = option_groups[0];
  auto& [term, convention, physics, anisotropy, model_error, coarse_model_error] = options;
  auto& [loss, huber_threshold, student_freedom] = term;
  visit(Option{"loss", group, "--loss", "", bounds::any,
               "What a residual costs: gaussian (half its square), or huber or student, which are "
               "robust to outliers"},
        loss, loss_names);
  visit(
      Option{"huber_threshold", group, "--huber-threshold", "standard deviations", bounds::positive,
             "Residual beyond which a datum pulls no harder; used with --loss huber"},
      huber_threshold);
  visit(Option{"student_freedom", group, "--student-freedom", "", bounds::positive,
               "Degrees of freedom of Student's t; used with --loss student"},
        student_freedom);
  visit(Option{"convention", group, "--convention", "", bounds::any,
               "physical, or wang2008: the paper's boundary condition, C = 2.1489"},
        convention, convention_names);
  visit(
      Option{"physics", group, "--physics", "", bounds::any,
             "diffusion; transport: predictions end at those of Monte Carlo, by a ratio renewed at "
             "every weight; or auto: transport where it finds another homogeneous block"},
      physics, physics_names);
  visit(Option{"anisotropy", group, "--anisotropy", "", bounds::share,
               "Henyey-Greenstein g of transport; diffusion knows kappa and mu alone"},
        anisotropy);
  auto& [relative, of_maximum] = model_error;
  visit(Option{"model_error_relative", group, "--model-error", "", bounds::not_negative,
               "Error of the model relative to each value, added to its standard deviation"},
        relative);
  visit(Option{"model_error_of_maximum", group, "--model-error-floor", "", bounds::not_negative,
               "Error of the model relative to the largest value of each pattern"},
        of_maximum);
  auto& [coarse_relative, coarse_of_maximum] = coarse_model_error;
  visit(Option{"coarse_model_error_relative", group, "", "", bounds::not_negative,
               "Error of the model relative to each value, on coarser grids"},
        coarse_relative);
  visit(Option{"coarse_model_error_of_maximum", group, "", "", bounds::not_negative,
               "Error of the model relative to each pattern's largest value, on coarser grids"},
        coarse_of_maximum);
}

template <class Regulariser, class Visitor>
void regulariser(Regulariser& options, Visitor& visit) {
  constexpr const char* group = option_groups[1];
  auto& [kind, edge_slope, anchor_length] = options;
  visit(Option{"regulariser", group, "--regulariser", "", bounds::any,
               "huber-tv: smooth kappa and mu that may have edges; h1: smooth alone; wang2008: the "
               "paper's, kappa alone "
               "and data unweighted, with the weight 1e-5 where --lambda gives no other"},
        kind, regulariser_names);
  visit(Option{"edge_slope", group, "--edge-slope", "log units per thickness", bounds::positive,
               "Slope beyond which a change counts as an edge; used with --regulariser huber-tv"},
        edge_slope);
  visit(Option{"anchor_length", group, "", "thicknesses", bounds::positive,
               "Length of features beyond which the fields are drawn to the homogeneous start"},
        anchor_length);
}

template <class Path, class Visitor>
void path(Path& options, Visitor& visit) {
  constexpr const char* group = option_groups[2];
  auto& [model, start_kappa, start_mu, weight, first_weight, last_weight, weight_factor,
         target_chi2, stage_tolerance, final_tolerance, stage_steps, max_levels, correct_grid] =
      options;
  visit(Option{"model", group, "--model", "", bounds::any,
               "homogeneous, layered (even layers across the light), volume, or auto: the simplest "
               "that the data do not reject, channel by channel"},
        model, model_names);
  visit(Option{"start_kappa", group, "--start-kappa", "mm", bounds::positive,
               "The search for the homogeneous start tries this kappa as well; needs --start-mu"},
        start_kappa);
  visit(Option{"start_mu", group, "--start-mu", "1/mm", bounds::positive,
               "The mu of that start; needs --start-kappa"},
        start_mu);
  visit(Option{"weight", group, "--weight,--lambda", "", bounds::not_negative,
               "The only weight of the regulariser, instead of choosing it; with --regulariser "
               "wang2008 the paper's lambda"},
        weight);
  visit(Option{"first_weight", group, "", "", bounds::positive,
               "Weight at which the path starts on the coarsest grid"},
        first_weight);
  visit(Option{"last_weight", group, "", "", bounds::positive,
               "Weight below which the path does not go"},
        last_weight);
  visit(Option{"weight_factor", group, "", "", bounds::below_one, "From one weight to the next"},
        weight_factor);
  visit(Option{"target_chi2", group, "--target-chi2", "", bounds::positive,
               "The weight is lowered until chi2 per value is this, and on while cross-validation "
               "expects a gain; above 1 for a smoother volume"},
        target_chi2);
  visit(Option{"stage_tolerance", group, "--stage-tolerance", "", bounds::below_one,
               "Relative decrease of the objective per step below which a weight is done"},
        stage_tolerance);
  visit(
      Option{"final_tolerance", group, "--final-tolerance", "", bounds::positive,
             "Relative decrease per step below which the last weight, and the fit, is done; at the "
             "latest where steps explain less than errors that pixels share"},
      final_tolerance);
  visit(Option{"stage_steps", group, "--stage-steps", "", bounds::at_least_one,
               "Most steps at one weight"},
        stage_steps);
  visit(Option{"max_levels", group, "--levels", "", bounds::at_least_one,
               "Most grids, from coarse to fine; 1 fits on the full grid at once"},
        max_levels);
  visit(Option{"correct_grid", group, "--no-grid-correction", "", bounds::any,
               "Predictions are corrected for the fitted grid's own error"},
        correct_grid);
}

template <class Solver, class Visitor>
void solver(Solver& options, Visitor& visit) {
  constexpr const char* group = option_groups[3];
  auto& [optimiser, coordinates, smooth_length, metric_probes, seed, backend] = options;
  auto& [method, memory, first_step, longest_step, max_backtracks, golden_tolerance] = optimiser;
  visit(
      Option{
          "optimiser", group, "--optimiser", "", bounds::any,
          "lbfgs, or wang2008: the paper's Polak-Ribière conjugate gradients with golden-section "
          "search, many times slower"},
      method, method_names);
  visit(Option{"optimiser_memory", group, "", "", bounds::at_least_one, "Pairs that L-BFGS keeps"},
        memory);
  visit(Option{"optimiser_first_step", group, "", "log units", bounds::positive,
               "Largest change of log kappa or log mu in the first step"},
        first_step);
  visit(Option{"optimiser_longest_step", group, "", "log units", bounds::positive,
               "Largest change of log kappa or log mu in any step"},
        longest_step);
  visit(Option{"optimiser_max_backtracks", group, "", "", bounds::at_least_one,
               "Halvings of a step before the search along it gives up"},
        max_backtracks);
  visit(Option{"optimiser_golden_tolerance", group, "", "", bounds::positive,
               "Final width of golden section's bracket over the step found"},
        golden_tolerance);
  visit(Option{"coordinates", group, "", "", bounds::any,
               "Coordinates the fit moves in: voxels, smooth (the regulariser's metric), informed "
               "(the data's too)"},
        coordinates, coordinates_names);
  visit(Option{"smooth_length", group, "", "thicknesses", bounds::positive,
               "Length beyond which the metric no longer favours smoother fields"},
        smooth_length);
  visit(Option{"metric_probes", group, "", "", bounds::not_negative,
               "Adjoint solves per weight for the data's share of the metric"},
        metric_probes);
  visit(Option{"seed", group, "", "", bounds::any, "Of random probes (--seed)"}, seed);
  auto& [device, precision, solve, batch, refined_tolerance, refined_memory_mb, loose_solves,
         operators, vectors] = backend;
  static_cast<void>(operators);  // given by a program, not by a user
  visit(Option{"device", group, "", "", bounds::any, "Part of an OpenCL device's name (--device)"},
        device);
  visit(Option{"precision", group, "--precision", "", bounds::any,
               "Precision of the diffusion solver: single, or double (slower)"},
        precision, precision_names);
  visit(Option{"vectors", group, "", "", bounds::any,
               "Memory that the fit's vectors stay in between steps: host, device, or automatic "
               "(that of a GPU where they fit)"},
        vectors, vector_place_names);
  auto& [tolerance, max_iterations] = solve;
  visit(Option{"solver_tolerance", group, "", "", bounds::positive,
               "Least relative residual that a diffusion solve is asked for"},
        tolerance);
  visit(Option{"solver_max_iterations", group, "", "", bounds::at_least_one,
               "Most iterations of a diffusion solve"},
        max_iterations);
  visit(Option{"batch", group, "", "patterns", bounds::at_least_one, "Patterns solved at once"},
        batch);
  visit(Option{"refined_tolerance", group, "", "", bounds::positive,
               "Relative residual of a solve on the grid twice as fine"},
        refined_tolerance);
  visit(Option{"refined_memory_mb", group, "", "MiB", bounds::positive,
               "Bound on the fields of such a solve"},
        refined_memory_mb);
  visit(
      Option{"loose_solves", group, "--no-loose-solves", "", bounds::any,
             "Solves leave residuals of a share of the data's deviations. Without: those of "
             "solver_tolerance and refined_tolerance, so that two programs end at the same volume"},
      loose_solves);
}

template <class Uncertainty, class Visitor>
void uncertainty(Uncertainty& options, Visitor& visit) {
  constexpr const char* group = option_groups[4];
  auto& [probes, sensitivity_probes] = options;
  visit(Option{"uncertainty_probes", group, "--uncertainty", "", bounds::not_negative,
               "Adjoint solves for the standard deviations of the volumes; 0 gives none", false},
        probes);
  visit(Option{"sensitivity_probes", group, "", "", bounds::not_negative,
               "Adjoint solves for where the data constrain the volume", false},
        sensitivity_probes);
}

}  // namespace description

template <class Options, class Visitor>
void describe(Options& options, Visitor&& visit) {
  auto& [data, regulariser, path, solver, uncertainty] = options;
  description::data(data, visit);
  description::regulariser(regulariser, visit);
  description::path(path, visit);
  description::solver(solver, visit);
  description::uncertainty(uncertainty, visit);
}

}  // namespace kappamu::inverse
