// The fit of one channel as it runs: what fit.cpp (steps), fit_path.cpp (grids and weights),
// fit_resume.cpp (from a checkpoint) and fit_result.cpp (what comes of it) share.
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "core/progress.h"
#include "inverse/fit/checkpoint.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_function.h"
#include "inverse/fit/fit_state.h"
#include "inverse/optimise/basis.h"
#include "inverse/problem/objective.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// One channel's fit; run() from start or checkpoint to the end.
class ChannelRun {
 public:
  ChannelRun(const SurfaceMeasurements& measurements, int channel, const FitOptions& options,
             const Checkpoint& checkpoint, Progress& progress, const Observer& observer,
             const FitContext& context);

  ChannelFit run();

 private:
  using Clock = std::chrono::steady_clock;

  void open_level();
  void set_basis();
  double thickness() const;
  Anchor anchor() const;
  double refresh_correction();
  bool resume();
  void require_possible(const FitState& state) const;
  bool become(FitState state);
  void begin();
  bool settle_for_simple_model();
  void begin_continued(const Continuation& continued);
  void begin_stage();
  void iterate_stage();
  void end_stage();
  double first_weight(double chi2) const;
  void finish_level();
  void finish_path();
  void conclude();
  void conclude_simple(const ModelTrial& trial);
  void finish(double chi2);
  ChannelFit result();

  double seconds() const {
    return state_.seconds + std::chrono::duration<double>(Clock::now() - start_).count();
  }
  Refinement refinement() const {
    const auto level = static_cast<std::size_t>(state_.level);
    if (state_.level == 0) return refine(ladder_[0]);
    return {ladder_[level - 1].setup, ladder_[level - 1].irradiance};
  }
  /// Whether the first weight on the finest grid is the fit's last.
  bool only_weight() const { return options_.path.weight.has_value() && !context_.interim; }
  double stage_tolerance() const {
    return state_.last_stage
               ? std::min(options_.path.stage_tolerance, options_.path.final_tolerance)
               : options_.path.stage_tolerance;
  }
  /// The regulariser of the grid that is fitted.
  Regulariser regulariser() const;
  void tell(const std::string& sentence) { progress_.warn(stage_name_ + ": " + sentence); }
  void warn(const std::string& sentence);
  void save();
  void record();

  const SurfaceMeasurements& measurements_;
  const FitOptions& options_;
  const Checkpoint& checkpoint_;
  Progress& progress_;
  const Observer& observer_;
  const FitContext& context_;
  int channel_;
  std::string stage_name_;
  CheckpointOrigin origin_;
  double per_value_;
  std::vector<Problem> ladder_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_save_ = Clock::now();
  FitState state_;
  std::unique_ptr<Objective> objective_;
  std::unique_ptr<Basis> basis_;
  std::unique_ptr<FitFunction> function_;
};

}  // namespace kappamu::inverse
