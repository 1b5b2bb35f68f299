// Everything a fit is between two steps: what a checkpoint (checkpoint.h) holds.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "inverse/fit/fit.h"
#include "inverse/optimise/basis.h"
#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

struct FitState {
  int level = 0;          ///< of the ladder of grids; 0 = finest
  bool in_stage = false;  ///< the weight has been set up and evaluated
  bool finished = false;
  bool ran_out = false;     ///< the last weight ended on stage_steps
  bool repeated = false;    ///< this weight has been minimised before, with another correction
  bool stagnated = false;   ///< lower weights stopped helping before the noise level
  bool last_stage = false;  ///< this weight ends the fit: to final_tolerance
  int stage_steps = 0;      ///< taken at this weight
  int small_decreases = 0;  ///< in a row
  double begun_chi2 = 0.0;  ///< per value where the weight was begun
  double last_chi2 = 0.0;   ///< at the end of the weight before, on this grid; 0 before the first
  double seconds = 0.0;     ///< spent by earlier runs
  double weight = 0.0;      ///< α
  double roughness = 0.0;   ///< R now
  double chi2 = 0.0;        ///< per value now
  CoefficientPair fields;   ///< where the weight was begun
  LateralBlocks blocks;     ///< the data's Hessian on this grid, for the metric
  OptimiserState optimiser;
  Vector correction;
  SolveCount solves;                   ///< on this grid
  std::vector<LayeredMedium> simpler;  ///< ChannelFit::simpler
  FitReport report;                    ///< so far

  std::vector<std::byte> bytes() const;
  /// Throws InputError, the end of a sentence "A checkpoint ...", unless `bytes` are those of a
  /// state. Whether that state fits a problem is ChannelRun::require_possible()'s to say.
  static FitState from(std::span<const std::byte> bytes);
};

/// No checkpoint of a fit of these is longer.
std::size_t most_checkpoint_bytes(const SurfaceMeasurements& measurements,
                                  const FitOptions& options);

}  // namespace kappamu::inverse
