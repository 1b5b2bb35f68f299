// The fit of one channel as it runs: what fit.cpp (the order of its steps), fit_weight.cpp (one
// weight), fit_model.cpp (models of few unknowns), fit_physics.cpp, fit_resume.cpp (from a
// checkpoint) and fit_result.cpp (what comes of it) share. Where it stands is PathPosition::phase.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/processor_time.h"
#include "core/progress.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_function.h"
#include "inverse/fit/fit_state.h"
#include "inverse/fit/regularisation_path.h"
#include "inverse/optimise/basis.h"
#include "inverse/problem/grid_path.h"

namespace kappamu::inverse {

GridPath make_grid_path(const SurfaceMeasurements& measurements, int channel,
                        const FitOptions& options);

/// One channel's fit; run() from start or checkpoint to the end.
class ChannelRun {
 public:
  ChannelRun(const SurfaceMeasurements& measurements, int channel, const FitOptions& options,
             const Checkpoint& checkpoint, Progress& progress, const Observer& observer,
             const FitContext& context);

  ChannelFit run();

 private:
  void open(int level, bool closer = false);
  AbsorptionScale scale() const;
  Basis basis(double weight, const LateralBlocks& blocks, double slope, double uncoupled) const;
  void set_basis();
  Anchor anchor() const;
  void set_physics(Physics physics);
  void choose_physics(const HomogeneousFit& start);
  bool resume();
  void require_possible(const FitState& state) const;
  void become(FitState state);
  void begin();
  HomogeneousFit refit_by_transport(HomogeneousFit start);
  bool settle_for_simple_model();
  void begin_continued(const Continuation& continued);
  void begin_weight();
  void minimise();
  bool correction_is_outdated() const;
  double renew_correction(const CoefficientPair& fields);
  void renew_correction_midway();
  void meet_correction();
  void go_on_with_weight();
  double shared_error() const;
  bool out_of_steps() const;
  void follow_path();
  std::optional<Outlook> outlook(double chi2) const;
  SharedErrors shared_errors_now() const;
  void conclude();
  void conclude_simple(const ModelTrial& trial);
  void finish(double chi2);
  void check_data(const std::vector<double>& prediction);
  Prior prior() const;
  ChannelFit result();

  double seconds() const { return state_.seconds + watch_.seconds(); }
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
  GridPath grid_;
  Stopwatch watch_;
  Stopwatch since_save_;
  FitState state_;
  RegularisationPath path_{options_.path, context_, state_.path};
  std::unique_ptr<Basis> basis_;
  std::unique_ptr<FitFunction> function_;
};

}  // namespace kappamu::inverse
