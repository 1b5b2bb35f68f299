// Everything a fit is between two steps: what a checkpoint (inverse/checkpoint/checkpoint.h) holds.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "inverse/fit/fit.h"
#include "inverse/fit/regularisation_path.h"
#include "inverse/optimise/basis.h"
#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

struct FitState {
  int level = 0;        ///< of GridLevels, 0 = finest; GridPath's, as correction and solves are
  bool closer = false;  ///< GridPath's too
  PathPosition path;
  int stage_steps = 0;          ///< taken at this weight
  int small_decreases = 0;      ///< in a row
  double seconds = 0.0;         ///< spent by earlier runs
  double roughness = 0.0;       ///< R now
  double chi2 = 0.0;            ///< per value now
  double corrected_chi2 = 0.0;  ///< per value at this weight where r was made
  CoefficientPair fields;       ///< where the weight was begun
  LateralBlocks blocks;         ///< the data's Hessian there, by the fields
  LateralBlocks scaled_blocks;  ///< as the optimiser's coordinates have it (absorption_scale.h)
  OptimiserState optimiser;
  Correction correction;
  SolveCount solves;                   ///< so far, on all grids
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
