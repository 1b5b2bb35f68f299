// The regularisation path of a fit: a strong weight α on coarse grids, from there down to the noise
// level of all octaves on the finest and on while other light gains, and at its end the last weight
// once more with more patience. It decides from χ² and from generalised cross-validation; what is
// minimised, and how, is ChannelRun's.
#pragma once

#include <optional>

#include "inverse/fit/fit.h"

namespace kappamu::inverse {

enum class FitPhase {
  descending,         ///< towards lower weights
  descending_again,   ///< the same weight a second time, with the correction r renewed
  last_weight,        ///< the weight that ends the fit, to final_tolerance
  last_weight_again,  ///< the same, with r renewed
  finished
};

/// Where a fit stands on its path; part of a checkpoint.
struct PathPosition {
  FitPhase phase = FitPhase::descending;
  double weight = 0.0;      ///< α
  double last_chi2 = 0.0;   ///< at the end of the weight before, on this grid; 0 before the first
  double last_score = 0.0;  ///< cross-validation's at the same end; 0 before the first
  PathEnd end = PathEnd::unknown;
};

/// χ²/(1 − γ/N)² per value, expected of light not fitted (Golub, Heath & Wahba 1979); `free_share`
/// is 1 − γ/N: N data, of which γ determine the volume.
double cross_validation(double chi2, double free_share);

/// At the minimum at one weight: 1 − γ/N; cross-validation's score to be expected at the next
/// weight over that at this one; whether steps below stage_tolerance would explain more than the
/// errors that pixels share; SharedErrors::excess.
struct Outlook {
  double free_share = 1.0;
  double next_score = 0.0;
  bool patience_gains = true;
  double excess = 0.0;
};

/// What follows the minimum at one weight.
struct NextStep {
  enum class What { minimise, finer_grid, conclude };  ///< the first at PathPosition::weight
  enum class From { found, begun };                    ///< the volume found, or that before it
  What what;
  From from = From::found;
  bool operator==(const NextStep&) const = default;
};

/// Moves `position`, which may be replaced by a checkpoint's at any time.
class RegularisationPath {
 public:
  RegularisationPath(const PathOptions& options, const FitContext& context, PathPosition& position)
      : options_(options), context_(context), at_(position) {}

  /// Levels are those of GridLevels: 0 is the finest. `chi2` is that of the homogeneous start.
  void start(double chi2, int level);
  /// From another fit's volume on the finest grid, one weight above where it ended.
  void start_from(double weight);
  /// On the next finer grid, `level`, where the volume so far has `chi2`.
  void refine(double chi2, int level);

  /// The minimum at this weight has `minimised` χ² per value by the correction r it was found with
  /// and `renewed` by r at the minimum. `outlook` is empty where γ is not known and on coarser
  /// grids.
  NextStep minimum(double minimised, double renewed, const std::optional<Outlook>& outlook,
                   int level);

  double next_weight() const { return at_.weight * options_.weight_factor; }
  bool at_last_weight() const {
    return at_.phase == FitPhase::last_weight || at_.phase == FitPhase::last_weight_again;
  }
  /// Relative decrease per step below which the minimum is found.
  double tolerance() const;
  /// No weight below this one may be tried: PathOptions::last_weight.
  bool at_lowest_weight() const { return next_weight() < options_.last_weight; }

 private:
  bool fixed_by_user() const { return options_.weight.has_value(); }
  void open(int level);
  PathEnd end_of(double renewed, double misfit, const std::optional<Outlook>& outlook) const;
  NextStep::What end_grid(const std::optional<Outlook>& outlook);

  const PathOptions& options_;
  const FitContext& context_;
  PathPosition& at_;
};

}  // namespace kappamu::inverse
