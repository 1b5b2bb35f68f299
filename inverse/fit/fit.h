// Surface measurements of one channel in, volumes of κ and μ out.
//
// Minimises ½ Σ w (r M(κ, μ) − d)² + α R over (log κ, log μ): from the best homogeneous block,
// coarse grid to fine, on the finest the weight α lowered from strong to the noise level, and the
// minimum found at each weight; r corrects for the grid's own error, and for diffusion's where
// transport is asked for, and is refreshed at every weight (objective.h, basis.h, docs/theory.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/grid.h"
#include "core/progress.h"
#include "core/surface_measurements.h"
#include "inverse/block_model/block_model.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/block_model/layer_freedom.h"
#include "inverse/data_checks/consistency.h"
#include "inverse/data_checks/shared_errors.h"
#include "inverse/fit/fit_options.h"
#include "inverse/optimise/optimiser.h"
#include "inverse/problem/objective.h"
#include "inverse/problem/predict.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/uncertainty.h"
#include "inverse/uncertainty/unresolved_structure.h"

namespace kappamu::inverse {

enum class FitStatus {
  converged,    ///< the last weight was minimised to stage_tolerance, at the noise level
  above_noise,  ///< the same, but lower weights stopped helping above the noise level
  ran_out       ///< stage_steps at the last weight, or last_weight, ended it
};
std::string to_string(FitStatus status);

/// Why no lower weight follows on the finest grid.
enum class PathEnd {
  unknown,      ///< it is not over
  asked,        ///< the user's weight, or another fit's
  noise,        ///< the data are explained to their noise
  validated,    ///< and a lower weight promises more error under other light
  model_error,  ///< above the noise a lower weight promises more error under other light
  lowest        ///< PathOptions::last_weight
};

/// One step of the optimiser; step 0 opens a weight.
struct StepRecord {
  int level = 0;        ///< grid, 0 = finest
  double weight = 0.0;  ///< α
  int step = 0;         ///< at this weight on this grid
  SolveCount solves{};  ///< so far, on all grids
  double objective = 0.0;
  double chi2_per_value = 0.0;
  double roughness = 0.0;  ///< R
  double seconds = 0.0;    ///< since the channel's start, earlier runs of a resumed fit included
};

struct FitReport {
  FitStatus status = FitStatus::ran_out;
  std::string reason;  ///< one sentence: why it stopped
  std::string backend;
  std::vector<StepRecord> history;
  std::vector<std::string> warnings;
  Physics physics = Physics::diffusion;  ///< the one taken
  std::string physics_reason;            ///< one sentence; empty where nothing was to decide
  ModelChoice model;
  Consistency consistency;
  SharedErrors shared;                    ///< of the patterns fitted
  double homogeneous_kappa = 0.0;         ///< [mm]
  double homogeneous_mu = 0.0;            ///< [1/mm]
  double homogeneous_log_residual = 0.0;  ///< rms of log prediction − log datum
  double chi2_per_value = 0.0;
  double weight = 0.0;  ///< α at the end
  PathEnd end = PathEnd::unknown;
  std::size_t data = 0;  ///< used
  SolveCount solves;     ///< of all grids, the start included
  double seconds = 0.0;
  bool resumed = false;
};

struct ChannelFit {
  Medium medium;
  /// [M][v][u], unit of SurfaceMeasurements::value, r included.
  std::vector<float> prediction;
  /// Root of the diagonal of JᵀWJ, J = ∂M/∂log κ or log μ of one voxel: sensitivity
  /// to the voxel alone, in standard deviations of the data per unit of log. Empty unless
  /// sensitivities or deviations are asked for.
  Volume<float> sensitivity_kappa;
  Volume<float> sensitivity_mu;
  Correction correction;  ///< r at the end
  /// Set for volumes whose deviations are asked for (fit_uncertainty.h).
  std::optional<Prior> prior;
  LateralBlocks blocks;   ///< prior_blocks() at the end; empty where there is no prior
  EvenChange unresolved;  ///< unresolved_structure() at the end
  LayerFreedom freedom;   ///< layer_freedom() at the end; empty where there is no prior
  /// Models of few unknowns that the fitted data rejected on the finest grid: prefer_simpler()
  /// (simpler_model.h) asks the validation patterns.
  std::vector<LayeredMedium> simpler;
  FitReport report;
};

/// How a fit survives being killed. `save` receives everything the next step needs; `load` gives
/// what was saved last, and where that turns out to be of no use and `load` is called again, what
/// was saved before; nothing after the last. On the same device the fit then ends in the same bits,
/// history and warnings. What is damaged or of another fit is passed over, with a warning
/// (checkpoint.h).
struct Checkpoint {
  std::function<void(std::span<const std::byte>)> save;
  std::function<std::optional<std::vector<std::byte>>()> load;
  std::string program;             ///< that fits: another one's checkpoints are not taken
  double interval_seconds = 30.0;  ///< between saves within a weight; a new weight always saves
};

/// Called with every record of the history as it is made: the fields on the grid they are fitted
/// on.
using Observer = std::function<void(const StepRecord& record, const GridShape& shape,
                                    const CoefficientPair& fields)>;

/// A finished fit to go on from, on the same grid.
struct Continuation {
  Medium medium;
  double homogeneous_kappa = 0.0;  ///< [mm]; what the fields are drawn to
  double homogeneous_mu = 0.0;     ///< [1/mm]
  double homogeneous_log_residual = 0.0;
  double weight = 0.0;                   ///< α it ended with
  PathEnd end = PathEnd::asked;          ///< why there, where this fit keeps that weight
  Physics physics = Physics::diffusion;  ///< taken, and its reason: what `auto` goes on with
  std::string physics_reason{};
};

/// Optional input beside measurements and options.
struct FitContext {
  /// Start from this volume, on the finest grid, instead of the homogeneous block.
  std::optional<Continuation> continued;
  /// Another fit goes on from this one (validated_fit.h): the path alone, no words on its volumes.
  bool interim = false;
};

/// How volumes that a fit by `physics`, none of them Physics::automatic, found predict light.
PredictOptions predict_options(const FitOptions& options, Physics physics);

/// Warnings on χ² far above the noise and on coefficients that the chosen physics or the grid
/// describes poorly.
std::vector<std::string> volume_warnings(const Medium& medium, const FitReport& report,
                                         const SurfaceMeasurements& measurements,
                                         const FitOptions& options);

/// Throws InputError for measurements no fit can start from.
ChannelFit fit_channel(const SurfaceMeasurements& measurements, int channel,
                       const FitOptions& options, const Checkpoint& checkpoint, Progress& progress,
                       const Observer& observer = {}, const FitContext& context = {});

}  // namespace kappamu::inverse
