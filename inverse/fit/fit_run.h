// Input, state and open grid of a fit, shared by its steps. Their order is in fit.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/processor_time.h"
#include "core/progress.h"
#include "inverse/fit/fit.h"
#include "inverse/problem/grid_path.h"

namespace kappamu::inverse {

/// State of the minimisation at one weight between two steps.
struct StageState {
  CoefficientPair begun;        ///< where the weight was begun
  LateralBlocks blocks;         ///< the data's Hessian there, by the fields
  LateralBlocks scaled_blocks;  ///< as the optimiser's coordinates have it (absorption_scale.h)
  OptimiserState optimiser;
  double chi2 = 0.0;            ///< per value now
  double corrected_chi2 = 0.0;  ///< per value where r was made
  int steps = 0;                ///< taken since the weight was begun or gone on with
  int small_decreases = 0;      ///< in a row
  bool again = false;           ///< r took its first minimum back: this is the second round
};

/// Where a fit stands between two steps: what a checkpoint holds (fit_state.cpp), so that the next
/// step of a fit that goes on from it is what it would have been. `level`, `closer`, `solves`,
/// `correction` and `stage` are filled for it alone.
struct FitState {
  int level = 0;        ///< of GridLevels, 0 = finest
  bool closer = false;  ///< GridPath::closer()
  double weight = 0.0;  ///< α
  bool last = false;    ///< this weight ends the fit, to a tighter accuracy
  bool finished = false;
  PathEnd end = PathEnd::unknown;
  double last_chi2 = 0.0;   ///< at the end of the weight before, on this grid; 0 before the first
  double last_score = 0.0;  ///< cross-validation's at the same end; 0 before the first
  double seconds = 0.0;     ///< spent by earlier runs
  CoefficientPair fields;   ///< the volume that the last minimum or grid gave
  SolveCount solves;        ///< so far, on all grids
  Correction correction;    ///< r
  StageState stage;         ///< of the weight; empty where the fit has finished
  std::vector<LayeredMedium> simpler;  ///< ChannelFit::simpler
  FitReport report;                    ///< so far

  std::vector<std::byte> bytes() const;
  /// Throws InputError, the end of a sentence "A checkpoint ...", unless `bytes` are those of a
  /// state.
  static FitState from(std::span<const std::byte> bytes);
};

/// No checkpoint of a fit of these is longer.
std::size_t most_checkpoint_bytes(const SurfaceMeasurements& measurements,
                                  const FitOptions& options);

/// One channel's fit as it runs.
struct FitRun {
  const SurfaceMeasurements& measurements;
  int channel;
  const FitOptions& options;
  const Checkpoint& checkpoint;
  Progress& progress;
  const Observer& observer;
  const FitContext& context;
  std::string stage_name;
  std::uint64_t origin;  ///< fingerprint(): what a checkpoint must not be mixed with
  GridPath grid;
  FitState state{};
  Stopwatch watch{};
  Stopwatch since_save{};

  bool fixed_weight() const { return options.path.weight.has_value(); }
  double seconds() const { return state.seconds + watch.seconds(); }

  void warn(const std::string& sentence);
  /// Adds what checks and searches beside the objective cost.
  void count(const SolveCount& solves);
  /// A record of the history; `fields` on the open grid are for the observer alone.
  void record(StepRecord step, const CoefficientPair& fields);
  /// So that a killed fit goes on from here; `stage` is that of the weight, none at the end.
  void save(const StageState& stage = {});
  void open(int level, bool closer = false);
  /// r is by this equation on every grid.
  void set_physics(Physics physics);
  /// r anew at `fields`; χ² per value with it. Before the last weight, where r and the volume still
  /// move more, by a quarter of the photons.
  double renew_correction(const CoefficientPair& fields);
};

/// The regulariser's anchor.
Anchor anchor_of(const FitRun& run);
/// With the fit's last α.
Prior prior_of(const FitRun& run);

}  // namespace kappamu::inverse
