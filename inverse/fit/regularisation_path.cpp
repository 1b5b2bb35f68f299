#include "inverse/fit/regularisation_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kappamu::inverse {

namespace {

/// χ² per value of a homogeneous start, and of what a coarser grid found, that the weights of the
/// path are made for.
constexpr double usual_homogeneous_chi2 = 100.0;
constexpr double usual_structured_chi2 = 200.0;
/// Times χ² as it was minimised that r, renewed, may make of it below the noise level.
constexpr double most_taken_back = 1.3;

/// χ² of the start counts how much sharper than its structure the data are: where it is large, a
/// usual weight leaps into the nearest valley that explains the data, and a rough one at that. By
/// whole steps of the path, so that where it ends does not hang on χ² of its start.
double sharpened(double weight, double excess, double weight_factor) {
  const double steps = std::ceil(std::log(std::max(1.0, excess)) / -std::log(weight_factor));
  return weight / std::pow(weight_factor, steps);
}

}  // namespace

double cross_validation(double chi2, double free_share) {
  return free_share > 0.0 ? chi2 / (free_share * free_share)
                          : std::numeric_limits<double>::infinity();
}

/// A weight fixed by the user is the last at once on the finest grid.
void RegularisationPath::open(int level) {
  const bool last = level == 0 && fixed_by_user() && !context_.interim;
  at_.phase = last ? FitPhase::last_weight : FitPhase::descending;
  at_.last_chi2 = 0.0;
  at_.last_score = 0.0;
  at_.end = fixed_by_user() ? PathEnd::asked : PathEnd::unknown;
}

void RegularisationPath::start(double chi2, int level) {
  open(level);
  at_.weight = options_.weight.value_or(
      sharpened(options_.first_weight, chi2 / usual_homogeneous_chi2, options_.weight_factor));
}

void RegularisationPath::start_from(double weight) {
  open(0);
  at_.weight =
      options_.weight.value_or(std::max(options_.last_weight, weight / options_.weight_factor));
}

void RegularisationPath::refine(double chi2, int level) {
  open(level);
  if (fixed_by_user()) return;
  const double usual = at_.weight;
  at_.weight = sharpened(usual, chi2 / usual_structured_chi2, options_.weight_factor);
}

NextStep RegularisationPath::minimum(double minimised, double renewed,
                                     const std::optional<Outlook>& outlook, int level) {
  using What = NextStep::What;
  using From = NextStep::From;
  const double target = options_.target_chi2;
  const bool first = at_.phase == FitPhase::descending || at_.phase == FitPhase::last_weight;
  // χ² by the new r is back above the noise, or far from where it was: this weight is low enough,
  // the volume not yet there. Not so where the user fixed it from the start, as [W] does.
  const bool taken_back =
      minimised <= target &&
      (renewed > target || (level == 0 && renewed > most_taken_back * minimised));
  const bool unsettled = (!fixed_by_user() || context_.continued) && first && taken_back;
  if (at_last_weight()) {
    at_.last_chi2 = renewed;
    if (!unsettled) return {What::conclude};
    at_.phase = FitPhase::last_weight_again;
    return {What::minimise};
  }
  // Above the noise level a lower weight that cross-validation expects to predict other light worse
  // fits the model's own error: the weight before it ends the path.
  const double score = outlook ? cross_validation(renewed, outlook->free_share) : 0.0;
  const double misfit = outlook ? std::max(renewed, outlook->excess) : renewed;
  const bool worse =
      !unsettled && at_.last_score > 0.0 && misfit > target && score > at_.last_score;
  if (worse && !fixed_by_user()) {
    at_.weight /= options_.weight_factor;
    at_.end = PathEnd::model_error;
    return {end_grid(outlook), From::begun};
  }
  if (unsettled) {
    at_.phase = FitPhase::descending_again;
    return {What::minimise};
  }
  // A lower weight on a coarse grid fits the grid's own error, along the valley of κ against μ.
  if (level > 0) return {What::finer_grid};
  const PathEnd end = end_of(renewed, misfit, outlook);
  at_.last_chi2 = renewed;
  at_.last_score = score;
  if (end != PathEnd::unknown) {
    at_.end = end;
    return {end_grid(outlook)};
  }
  at_.phase = FitPhase::descending;
  at_.weight = next_weight();
  return {What::minimise};
}

/// `misfit` is χ², or what of it an octave has beyond chance, if more. Where it is 1 the noise may
/// have been reached, by variances that may be overstated: whether the next weight would predict
/// other light better is for cross-validation to say.
PathEnd RegularisationPath::end_of(double renewed, double misfit,
                                   const std::optional<Outlook>& outlook) const {
  const double target = options_.target_chi2;
  if (fixed_by_user()) return PathEnd::asked;
  if (misfit <= target) {
    const bool smoother_asked = target > 1.0;
    if (!outlook || smoother_asked) return PathEnd::noise;
    if (outlook->next_score > 1.0) return PathEnd::validated;
  }
  if (at_.last_chi2 > 0.0 && renewed > (1.0 - options_.stagnation) * at_.last_chi2) {
    return PathEnd::no_gain;
  }
  return at_lowest_weight() ? PathEnd::lowest : PathEnd::unknown;
}

/// On the finest grid the last weight once more, with the correction renewed and more patience:
/// those before it only lead there.
NextStep::What RegularisationPath::end_grid(const std::optional<Outlook>& outlook) {
  const bool patient =
      options_.final_tolerance < options_.stage_tolerance && (!outlook || outlook->patience_gains);
  if (context_.interim || !patient) {
    return NextStep::What::conclude;
  }
  at_.phase = FitPhase::last_weight;
  return NextStep::What::minimise;
}

double RegularisationPath::tolerance() const {
  return at_last_weight() ? std::min(options_.stage_tolerance, options_.final_tolerance)
                          : options_.stage_tolerance;
}

}  // namespace kappamu::inverse
