// Every threshold of the inverse problem: name, value, where it comes from. What a user may change
// is in fit/fit_options.h. Populations and tables that are named lie in studies/notes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kappamu::inverse::defaults {

// --- The path of a fit (fit/path_rules.h, fit/minimise.h, fit/start.h, fit/conclusion.h) ---

/// χ² per value of a homogeneous start, and of the volume of a coarser grid, up to which the usual
/// weights hold (studies/notes/weight-rules-and-gains.md; worth: studies/notes/fit-ablation.md).
inline constexpr double usual_homogeneous_chi2 = 100.0;
inline constexpr double usual_structured_chi2 = 200.0;
/// Ratio of χ² with r renewed to χ² as minimised, beyond which a weight is minimised once more
/// below the noise level. On unseen blocks the second minimisation lowers E by 5 %, at 0.3 % noise
/// by 12 % (studies/notes/fit-ablation.md).
inline constexpr double most_reverted = 1.3;
/// PhotonOptions::noise before the last weight: a quarter of the photons, since r and the volume
/// still move by more (studies/notes/fit-choices.md, "A volume by transport").
inline constexpr double photon_noise_midway = 2.0;
/// Small decreases in a row that end a minimisation: a long step often follows a single short one.
/// One in place of two costs 3 % of E (studies/notes/fit-ablation.md).
inline constexpr int few_decreases = 2;
/// Share of Σ w d² that a step must explain if pixels share errors: half the square of 1e-4, the
/// least of such errors. Chosen on the paper's samples (studies/notes/fit-path.md, "Steps smaller
/// than the errors of photographs"); on unseen blocks it changes nothing (fit-ablation.md).
inline constexpr double least_of_light = 5e-9;
/// χ² over target_chi2 at the start of a minimisation, beyond which r is renewed once the noise is
/// reached. Chosen on the paper's samples (studies/notes/fit-path.md, "Closer before the finest
/// grid, and r on the way"); on unseen blocks it changes nothing (fit-ablation.md).
inline constexpr double far_from_noise = 6.0;
/// Relative decrease of χ² by the last minimisation below which r, made at its beginning, holds at
/// its end: renewed there, r changed χ² by a fifteenth of that.
inline constexpr double small_change_of_chi2 = 0.1;
/// μ₀ of the optimiser's coordinate (absorption_scale.h) over μ of the homogeneous block
/// (studies/notes/fit-path.md, "μ in place of its logarithm"). Work rises by 6 % without that
/// coordinate (studies/notes/fit-ablation.md).
inline constexpr double little_absorption = 0.2;
/// BasisOptions::off_diagonal_damping: in a heterogeneous block lateral frequencies couple, and one
/// alone does not determine every combination of depths (studies/notes/fit-path.md, "Softer where
/// the metric is stiff"). E rises by 5 % without it (studies/notes/fit-ablation.md).
inline constexpr double off_diagonal_damping = 0.5;
/// The homogeneous start by transport has converged if renewing r moves it by less than this [log
/// units], or by less than this share of its uncertainty; most renewals.
inline constexpr double start_tolerance = 0.02;
inline constexpr double start_certain = 0.25;
inline constexpr int most_starts = 8;
/// χ² per value above which stopping there is worth a warning (docs/theory.md, 4).
inline constexpr double suspicious_chi2 = 1.5;
/// Thickness [transport mean free paths] below which most of the light passes unscattered.
inline constexpr double thinnest = 1.5;

namespace shared_deviation {  // uncertainty/shared_deviation.h
/// Deviation of log κ over the spread of log κ within the layer of most contrast, and over the
/// spread of the layers' means; deviation of log μ over that of log κ; change by unresolved
/// structure of the truth over that of the fit. Measured on seeds 41 to 55 of the population and on
/// the paper's samples (docs/theory.md, 5).
inline constexpr double share_within_layer = 0.5;
inline constexpr double share_of_means = 2.0;
inline constexpr double mu_over_kappa = 3.5;
inline constexpr double unresolved_kappa_of_truth = 3.0;
inline constexpr double unresolved_mu_of_truth = 2.0;
}  // namespace shared_deviation

namespace local_information {  // uncertainty/local_information.h
/// Deviation of the Gaussian mean over voxels of a layer [voxels]: few probes make the sensitivity.
inline constexpr double pooling = 1.5;
}  // namespace local_information

namespace point_spread {  // uncertainty/point_spread.h
/// A definition: what of a wave is found where a blot's width is read off.
inline constexpr double half_found = 0.5;
}  // namespace point_spread

namespace summary {  // uncertainty/uncertainty_summary.cpp
inline constexpr double undetermined_factor =
    2.0;  // beyond it a coefficient is reported as undetermined
inline constexpr double decided_by_data = 0.5;  // resolution below which the smoothing dominates
inline constexpr double trading = 0.5;          // correlation from which κ and μ trade
}  // namespace summary

namespace volume_errors {  // data_checks/volume_errors.h
/// Adjoint solves for the metric.
inline constexpr int probes = 4;
}  // namespace volume_errors

namespace physics_choice {  // data_checks/physics_choice.h
/// Followed by photons: the check costs some seconds (docs/theory.md, 4).
inline constexpr int pilot_patterns = 4;
/// Relative noise of a pixel: log (r M) is then 1 % too low on average.
inline constexpr double pilot_noise = 0.15;
/// Errors of volumes by transport themselves (docs/limits.md).
inline constexpr double tolerated_kappa = 0.05;
inline constexpr double tolerated_mu = 0.15;
/// An error of so much of a deviation adds little to it.
inline constexpr double negligible_deviations = 0.5;
}  // namespace physics_choice

namespace consistency {  // data_checks/consistency.h
/// One false accusation in a thousand.
inline constexpr double most_deviations = 3.0;
/// What depth and structure common to all patterns do to the scale of the best homogeneous block
/// [log], one standard deviation over layered and inhomogeneous blocks; what weak layers that
/// look like a factor do, where such a block explains everything; and what calibration leaves
/// (docs/theory.md, 4; studies/notes/fit-choices.md).
inline constexpr double structure_spread = 0.16;
inline constexpr double weak_layers_spread = 0.025;
inline constexpr double calibration_spread = 0.01;
inline constexpr double shift_spread = 0.08;  ///< the same of the shift [voxels]
/// The same of what volumes find: what grid, prior and calibration leave.
inline constexpr double volume_shift_spread = 0.04;
/// VolumeErrors::scale_gain beyond which values are reported as too high. Right data exceed it in
/// one of 200 blocks, data 1.2 times too high in most (studies/notes/fit-choices.md).
inline constexpr double most_scale_gain = 0.15;
/// Steps of conjugate gradients for the volume's check; those after which a scale is given up, and
/// the gain below which it is. Of 92 blocks that end above 0.15 all but one exceed 0.05 after 16
/// steps (studies/notes/fit-choices.md).
inline constexpr int most_steps = 48;
inline constexpr int early_steps = 16;
inline constexpr double least_early_gain = 0.03;
/// Voxels of twice the edge give the same result for an eighth of the work, if there are enough.
inline constexpr int enough_voxels = 8;
/// Below, the block is even enough across the light to ask for its refractive index; the indices
/// that are tried, and what counts as the same.
inline constexpr double nearly_even = 0.1;
inline constexpr std::array<double, 5> usual_etas{1.3, 1.33, 1.4, 1.5, 1.6};
inline constexpr double same_eta = 0.015;
}  // namespace consistency

namespace scale_and_shift {  // data_checks/scale_and_shift.h
inline constexpr double step_tolerance = 2e-3;
/// χ² per value from which a second correction of the grid changes nothing that matters.
inline constexpr double far_from_data = 4.0;
inline constexpr double tolerated_misfit = 0.05;
/// Heterogeneity at the start, and its least value.
inline constexpr double usual_heterogeneity = 0.3;
inline constexpr double least_heterogeneity = 1e-3;
/// Prior deviation of log scale and, over the face's extent, of the shift: for light that
/// determines neither.
inline constexpr double scale_spread = 1.0;
inline constexpr double free_shift_spread = 0.25;
/// Beyond, the fit has diverged.
inline constexpr double largest_log_scale = 2.5;
inline constexpr double largest_shift = 0.25;  ///< of the face's extent
}  // namespace scale_and_shift

namespace homogeneous {  // block_model/homogeneous.h
/// Spread of log data that a homogeneous block cannot follow: keeps bright, precise pixels from
/// outvoting the rest.
inline constexpr double heterogeneity = 0.3;
/// Largest last step [log units] of what leads to the end, and there.
inline constexpr double interim_tolerance = 2e-2;
inline constexpr double step_tolerance = 1e-3;
/// Longest step [log units] (studies/notes/fit-choices.md, "One Levenberg-Marquardt").
inline constexpr double longest_step = 1.5;
/// Significance of a datum: one in a thousand dark pixels exceeds it.
inline constexpr double above_noise_deviations = 3.0;
/// Difference of log κ and log μ for the Jacobian: a solve on a grid is right to 1e-4.
inline constexpr double difference = 0.03;
/// Pixels of all patterns that the search reads, its least number along an edge, and the fewest
/// data above noise before more are read. They bound the search's time to a second.
inline constexpr double enough_pixels = 8000.0;
inline constexpr int least_side = 6;
inline constexpr std::size_t least_used = 200;
/// Voxels along both edges of the lit face from which the search reads light and data of pairs of
/// voxels, and then descends once with all.
inline constexpr int many_voxels = 160;
/// Table of starts: κ over the thickness and 3κμ, from juice to marble (Jensen et al. 2001) at any
/// size of block; descents from its lowest places.
inline constexpr int rows = 16, columns = 11;
inline constexpr std::size_t most_descents = 6;
inline constexpr double first_kappa = 1e-3, last_kappa = 3.0;
inline constexpr double first_share = 1e-5, last_share = 0.6;
/// Descents of every place, each with the prior's weight that the last left.
inline constexpr int prior_rounds = 4;
}  // namespace homogeneous

namespace systematic_error {  // block_model/systematic_error.h
/// Below, an error of the data may be chance.
inline constexpr double sure_deviations = 3.0;
/// Lags are counted to here [pixels]; correlation lengths are sought between the two.
inline constexpr int longest_lag = 8;
inline constexpr double shortest_length = 0.5;
inline constexpr double longest_length = 6.0;
inline constexpr double length_factor = 1.12;
}  // namespace systematic_error

namespace model_evidence {  // block_model/model_evidence.h
/// One false rejection in a thousand.
inline constexpr double deviations = 3.0;
}  // namespace model_evidence

namespace layers {  // block_model/model_layers.h
inline constexpr double most_bend = 0.75;
/// A step that promises less of χ² moves no unknown by more than 0.3 of its standard error.
inline constexpr double negligible = 0.1;
/// Far above the noise, where the model will be rejected anyway, this share of χ² is as good.
inline constexpr double negligible_share = 2e-3;
/// No descent keeps so many times what its next step promises.
inline constexpr double most_kept = 3.0;
}  // namespace layers

namespace layer_freedom {  // block_model/layer_freedom.h
/// Layers that the profile along the depth is cut into: two tangent solves each.
inline constexpr int layers = 6;
}  // namespace layer_freedom

namespace model_choice {  // block_model/model_choice.h
/// Share of the stated variance that a misfit may have: 0.22 standard deviations, E = 5e-6 at 1 %
/// noise (docs/theory.md, 4). Rise of χ² per value that fewer layers may cost.
inline constexpr double tolerated = 0.05;
inline constexpr double tolerated_rise = 0.01;
inline constexpr int most_layers = 16;
/// Largest error of the data, relative to them, that is taken for systematic; deviation of every
/// error common to all pixels; largest structure_ratio() of residuals without structure, and the
/// draws that it is compared with. Measured by `inverse_test --gtest_filter='SystematicError.*'`.
inline constexpr double most_systematic = 0.015;
inline constexpr double common_error = 0.01;
inline constexpr double most_structure = 2.8;
inline constexpr int draws = 8;
/// A refreshed correction that moves χ² by less than this share needs no further descent.
inline constexpr double settled = 0.003;
inline constexpr int most_corrections = 4;
/// The same by photons: none of the unknowns [log units] moved by more.
inline constexpr double settled_move = 0.01;
inline constexpr int most_by_transport = 15;
/// χ² per value over what is not rejected, and over the lowest so far: renewals of r that leave it
/// above both lead nowhere.
inline constexpr double far_off = 2.0;
inline constexpr double no_gain = 0.9;
/// Errors of the data make a homogeneous block look layered once in a thousand.
inline constexpr double chance_deviations = 3.0;
}  // namespace model_choice

namespace simpler_model {  // validation/simpler_model.h
/// Pixels whose misfits go together: sampling errors are those between blocks of this edge.
inline constexpr int block_edge = 4;
}  // namespace simpler_model

namespace notes {  // validation/notes.h
/// A rim that masks leave out is known from beside it.
inline constexpr double much_unseen = 0.2;  // of the seen face
/// Voxels so small resolve no more than larger ones (docs/limits.md, "The fit").
inline constexpr double fine_voxel = 0.2;     // of a mean free path
inline constexpr double advised_voxel = 0.5;  // the same
inline constexpr int fewest_voxels = 4;       // that the advice leaves across the block
/// Outliers are reported if χ² exceeds this, if values beyond so many of the others' standard
/// deviations make most of it, and if they are fewer than this share.
inline constexpr double high_chi2 = 1.5;
inline constexpr double far = 5.0;
inline constexpr double few = 0.1;
/// χ² of validation patterns above so many times the fitted is no chance of a few patterns.
inline constexpr double surprising_chi2 = 4.0;
}  // namespace notes

namespace predict {  // problem/predict.h
/// Photons' noise of a prediction by transport: half of this share of each value and of this share
/// of the pattern's largest, and so at most what usual data have; or half of its datum's.
inline constexpr double photon_noise = 0.005;
inline constexpr double photon_noise_floor = 5e-5;
}  // namespace predict

namespace photon_ratio {                                  // problem/photon_ratio.h
inline constexpr std::uint64_t fewest_photons = 1 << 14;  // of each pattern
inline constexpr std::uint64_t most_photons = 1 << 22;
/// Variance of a smoothed pixel over its datum's: smoothing goes no further.
inline constexpr double tolerated_noise = 0.25;
/// Relative deviation tolerated where there is no datum.
inline constexpr double unseen_noise = 0.1;
/// Part of a slope that its regression may leave unexplained; photons of the ratio over a slope's.
inline constexpr double slope_misfit = 0.1;
inline constexpr std::uint64_t photons_over_slope = 4;
/// μ/σt' of a voxel that leaves no scattering, and κ below which a voxel is a mirror to light and
/// slows all photons, as shares of the median κ and of the voxel's edge (200 mean free paths): none
/// is a material, all occur on a fit's way.
inline constexpr double most_absorption = 0.999;
inline constexpr double least_kappa_of_median = 0.02;
inline constexpr double least_kappa_of_voxel = 1.0 / 600.0;
}  // namespace photon_ratio

namespace grid_path {  // problem/grid_path.h
/// Solves leave a residual of this share of a datum's usual deviation, but of no more than
/// `loosest`: fits end at the same E as with exact ones (docs/theory.md, section 4).
inline constexpr double of_deviation = 0.3;
inline constexpr double loosest = 3e-3;
/// An error of a gradient by so small a share changes nothing of where they end.
inline constexpr double of_gradients = 2e-2;
/// Nothing cancels an error of r: it is kept far below the deviation that one datum in twenty has
/// at most. Begun with the coarser grid's light, a marble's r is off by 0.02 of it
/// (studies/notes/fit-path.md, "Where the marble's fit spends its time").
inline constexpr double of_least_deviation = 0.1;
inline constexpr double loosest_correction = 1e-3;
}  // namespace grid_path

namespace grid_levels {  // problem/grid_levels.h
/// Along every axis: fewer resolve neither the decay along the light nor a patch.
inline constexpr int fewest_voxels = 4;
/// Masks leave a coarser grid fewer whole data than the fine one has.
inline constexpr std::size_t fewest_data = 16;
/// Share of the coarse grids' model error in the second fit of the last coarse grid. Chosen on the
/// paper's samples (studies/notes/fit-path.md, "Closer before the finest grid, and r on the way").
inline constexpr double closer_share = 1.0 / 3.0;
}  // namespace grid_levels

namespace expected {  // of blocks before their data are seen: starts, layers, scale and shift
/// Share of collisions that absorb, 3κμ, and the spread of its logarithm: marble, milk, wax, skin
/// and juices lie within two spreads (Jensen et al. 2001, table 1).
inline constexpr double absorption = 3e-3;
inline constexpr double absorption_spread = 2.0;
/// Spread of log κ and log μ between neighbouring layers.
inline constexpr double layer_spread = 1.0;
/// Vanishing predictions count as this share of the datum.
inline constexpr double darkest_ratio = 1e-6;
}  // namespace expected

namespace correction {  // problem/objective_correction.cpp
/// r outside is no grid error but noise of vanishing light.
inline constexpr double min_correction = 0.25;
inline constexpr double max_correction = 4.0;
}  // namespace correction

namespace levenberg_marquardt {  // optimise/levenberg_marquardt.h
inline constexpr double first_damping = 1e-2;
/// Factor on the damping after a failed step, doubled with each failure in a row.
inline constexpr double first_raise = 8.0;
/// Share of the trace: damps directions that neither residuals nor prior determine.
inline constexpr double least_damping = 1e-12;
/// A step that keeps less of its promise asks for a fresh Jacobian.
inline constexpr double trusted_step = 0.25;
/// One that keeps less than this may be bent: for six layers 7 times fewer solves (fit-path.md).
inline constexpr double kept_well = 0.75;
}  // namespace levenberg_marquardt

namespace lateral_hessian {  // optimise/lateral_hessian.h
/// Samples that a row's variance is estimated from.
inline constexpr int enough_for_variances = 8;
}  // namespace lateral_hessian

namespace optimiser {  // optimise/optimiser.h
/// Share of the promised decrease a step must keep (Armijo).
inline constexpr double sufficient_decrease = 1e-4;
/// Factor on s·y/y·y, the usual guess of H⁻¹: y is dominated by the stiffest directions, which the
/// pairs represent (studies/notes/fit-path.md, "Softer where the metric is stiff").
inline constexpr double softer = 2.0;
}  // namespace optimiser

namespace memory {  // fit/fit_memory.h
/// Doubles per voxel beside the optimiser's pairs: coefficients, coordinates, gradients, trial
/// points, the products a gradient is made of, the regulariser's work.
inline constexpr double working_doubles = 60.0;
/// Doubles per fine voxel of a refined solve: split coefficients, their logarithms' exponentials.
inline constexpr double refined_doubles = 4.0;
}  // namespace memory

}  // namespace kappamu::inverse::defaults
