// The fit of one channel as it runs: what fit.cpp (steps), fit_path.cpp (from one weight or grid to
// the next), fit_resume.cpp (from a checkpoint) and fit_result.cpp (what comes of it) share.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "core/progress.h"
#include "inverse/fit/checkpoint.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_function.h"
#include "inverse/fit/fit_state.h"
#include "inverse/fit/regularisation_path.h"
#include "inverse/optimise/basis.h"
#include "inverse/problem/grid_levels.h"
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
  /// What ended the steps at one weight.
  enum class StepsEnd { minimum, stage_steps };

  void open_level();
  void set_basis();
  double thickness() const;
  Anchor anchor() const;
  double refresh_correction();
  void set_physics(Physics physics);
  void choose_physics(double kappa, double mu);
  bool resume();
  void require_possible(const FitState& state) const;
  bool become(FitState state);
  void begin();
  HomogeneousFit refit_by_transport(HomogeneousFit start);
  bool settle_for_simple_model();
  void begin_continued(const Continuation& continued);
  void begin_weight();
  StepsEnd minimise();
  void follow_path(StepsEnd end);
  double cross_validation(double chi2) const;
  void refine();
  void conclude(StepsEnd end);
  void conclude_simple(const ModelTrial& trial);
  void finish(double chi2);
  ChannelFit result();

  double seconds() const {
    return state_.seconds + std::chrono::duration<double>(Clock::now() - start_).count();
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
  GridLevels levels_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_save_ = Clock::now();
  FitState state_;
  RegularisationPath path_{options_.path, context_, state_.path};
  std::unique_ptr<Objective> objective_;
  std::unique_ptr<Basis> basis_;
  std::unique_ptr<FitFunction> function_;
};

}  // namespace kappamu::inverse
