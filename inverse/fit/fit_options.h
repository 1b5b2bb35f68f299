// What a fit may be asked for. Defaults are here; names, bounds, units and a sentence on each are
// in describe_options.h, the table made of them in docs/reference/fit-options.md.
#pragma once

#include <cstdint>
#include <optional>

#include "inverse/block_model/block_model.h"
#include "inverse/optimise/basis.h"
#include "inverse/optimise/optimiser.h"
#include "inverse/problem/objective.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

/// The data term.
struct DataOptions {
  DataTermOptions term;
  forward::Convention convention = forward::Convention::physical;
  Physics physics = Physics::diffusion;
  double anisotropy = 0.0;                    ///< g of transport
  ModelError model_error{0.001, 5e-5};        ///< on the finest grid
  ModelError coarse_model_error{0.03, 3e-3};  ///< on the others
};

/// The regulariser (roughness.h).
struct RegulariserOptions {
  RegulariserKind kind = RegulariserKind::huber_tv;
  double edge_slope = 1.0;
  double anchor_length = 10.0;
};

/// From start to end: models, grids and weights.
struct PathOptions {
  Model model = Model::automatic;
  /// A further start of the search for the homogeneous block; both or neither.
  std::optional<double> start_kappa;  ///< [mm]
  std::optional<double> start_mu;     ///< [1/mm]
  std::optional<double> weight;       ///< α, or [W]'s λ with [W]'s regulariser
  double first_weight = 3000.0;
  double last_weight = 1e-3;
  double weight_factor = 0.3;
  double target_chi2 = 1.0;
  double stage_tolerance = 1e-3;
  double final_tolerance = 3e-4;  ///< at least stage_tolerance: the path's last weight is the fit's
  int stage_steps = 400;
  int max_levels = 4;
  bool correct_grid = true;
};

/// How each minimum is found.
struct SolverOptions {
  OptimiserOptions optimiser;
  Coordinates coordinates = Coordinates::informed;
  double smooth_length = 1.0;
  int metric_probes = 2;
  std::uint64_t seed = 1;
  Backend backend;
};

struct FitOptions {
  DataOptions data;
  RegulariserOptions regulariser;
  PathOptions path;
  SolverOptions solver;
  UncertaintyOptions uncertainty;
};

/// Throws InputError naming option and bound.
void validate(const FitOptions& options);

}  // namespace kappamu::inverse
