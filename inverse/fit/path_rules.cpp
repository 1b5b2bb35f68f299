#include "inverse/fit/path_rules.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

/// The weight raised by whole steps of the path until it exceeds `weight` times `excess`. A start
/// with a large χ² needs a larger weight: with the usual one the fit goes to the nearest minimum
/// that explains the data, which is rough. Whole steps keep the end of the path independent of χ²
/// at its start.
double sharpened(double weight, double excess, double weight_factor) {
  const double steps = std::ceil(std::log(std::max(1.0, excess)) / -std::log(weight_factor));
  return weight / std::pow(weight_factor, steps);
}

}  // namespace

double cross_validation(double chi2, double free_share) {
  return free_share > 0.0 ? chi2 / (free_share * free_share)
                          : std::numeric_limits<double>::infinity();
}

double first_weight(const PathOptions& options, double chi2) {
  return options.weight.value_or(sharpened(
      options.first_weight, chi2 / defaults::usual_homogeneous_chi2, options.weight_factor));
}

double weight_on_finer_grid(const PathOptions& options, double weight, double chi2) {
  return options.weight.value_or(
      sharpened(weight, chi2 / defaults::usual_structured_chi2, options.weight_factor));
}

double weight_going_on(const PathOptions& options, double weight) {
  return options.weight.value_or(std::max(options.last_weight, weight / options.weight_factor));
}

bool is_reverted(const PathOptions& options, const Minimum& minimum, bool finest) {
  return minimum.minimised <= options.target_chi2 &&
         (minimum.renewed > options.target_chi2 ||
          (finest && minimum.renewed > defaults::most_reverted * minimum.minimised));
}

bool correction_holds(double corrected_chi2, double chi2) {
  return corrected_chi2 < (1.0 + defaults::small_change_of_chi2) * chi2;
}

PathEnd end_of_path(const PathOptions& options, double weight, const Minimum& minimum,
                    const std::optional<Outlook>& outlook, double score_before) {
  if (options.weight) return PathEnd::asked;
  const double renewed = minimum.renewed;
  // χ², or what of it an octave has beyond chance, if more.
  const double misfit = outlook ? std::max(renewed, outlook->excess) : renewed;
  if (misfit > options.target_chi2) {
    // A lower weight that predicts other light worse fits the model's own error.
    const double score = outlook ? cross_validation(renewed, outlook->free_share) : 0.0;
    if (score_before > 0.0 && score > score_before) return PathEnd::model_error;
  } else {
    // χ² reaches the noise early if variances are overstated. Cross-validation therefore decides
    // whether the next weight would predict other light better.
    const bool smoother_asked = options.target_chi2 > 1.0;
    if (!outlook || smoother_asked) return PathEnd::noise;
    if (outlook->next_score > 1.0) return PathEnd::validated;
  }
  return weight * options.weight_factor < options.last_weight ? PathEnd::lowest : PathEnd::unknown;
}

bool needs_tighter_end(const PathOptions& options, const std::optional<Outlook>& outlook) {
  return options.final_tolerance < options.stage_tolerance &&
         (!outlook || outlook->tighter_end_gains);
}

double tolerance(const PathOptions& options, bool last) {
  return last ? std::min(options.stage_tolerance, options.final_tolerance)
              : options.stage_tolerance;
}

}  // namespace kappamu::inverse
