// How the weight α of the regulariser goes: by χ² and by generalised cross-validation. What is
// minimised, and how, is minimise.h's; the order of weights and grids is fit.cpp's.
//
// The path starts with a strong regulariser and lowers α by a constant factor to the noise level
// (discrepancy principle), below it while generalised cross-validation expects other light to be
// predicted better.
#pragma once

#include <optional>

#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// χ²/(1 − γ/N)² per value, expected of light not fitted (Golub, Heath & Wahba 1979); `free_share`
/// is 1 − γ/N: N data, of which γ determine the volume.
double cross_validation(double chi2, double free_share);

/// The first weight where the homogeneous start has `chi2` per value.
double first_weight(const PathOptions& options, double chi2);
/// The weight to go on with on a finer grid, where the volume found by `weight` has `chi2`.
double weight_on_finer_grid(const PathOptions& options, double weight, double chi2);
/// The first weight from another fit's volume, which ended with `weight`: one above.
double weight_going_on(const PathOptions& options, double weight);

/// χ² per value at the minimum at one weight: by the correction r it was found with, and by r
/// renewed there.
struct Minimum {
  double minimised = 0.0;
  double renewed = 0.0;
};

/// Whether r, renewed, takes the minimum back above the noise, or far from where it was: the weight
/// is low enough, the volume not yet there.
bool is_reverted(const PathOptions& options, const Minimum& minimum, bool finest);

/// Whether r, made where χ² per value was `corrected_chi2`, holds at a minimum of `chi2`.
bool correction_holds(double corrected_chi2, double chi2);

/// At the minimum at one weight on the finest grid.
struct Outlook {
  double free_share = 1.0;  ///< 1 − γ/N
  /// Cross-validation's score to be expected at the next weight over that at this one.
  double next_score = 0.0;
  bool tighter_end_gains = true;  ///< steps below stage_tolerance explain more than shared errors
  double excess = 0.0;            ///< SharedErrors::excess
};

/// Whether `weight` ends the path on the finest grid, and why: PathEnd::unknown where a lower one
/// follows, PathEnd::model_error where the one before is taken instead. `outlook` is empty where γ
/// is not known. `score_before`: cross-validation's at the weight before on this grid, 0 before the
/// first.
PathEnd end_of_path(const PathOptions& options, double weight, const Minimum& minimum,
                    const std::optional<Outlook>& outlook, double score_before);

/// Whether the weight that ends the path is minimised once more, to final_tolerance.
bool needs_tighter_end(const PathOptions& options, const std::optional<Outlook>& outlook);

/// Relative decrease per step below which a minimum is found.
double tolerance(const PathOptions& options, bool last);

}  // namespace kappamu::inverse
