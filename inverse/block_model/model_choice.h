// The simplest block that the data do not reject: homogeneous, else layered, else a volume
// (docs/theory.md, section 5). Where fewer unknowns explain the data, every further one only fits
// their noise.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "inverse/block_model/block_model.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/problem/grid_levels.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

struct SimpleFit {
  LayeredMedium medium;
  Eigen::MatrixXd normal;          ///< LayerFitter::normal()
  Eigen::MatrixXd slope;           ///< LayerFitter::slope_covariance() of `systematic`
  SystematicError systematic;      ///< of its residuals; finest grid only
  std::vector<double> residual;    ///< LayerFitter::residual_without_common(); the same
  CoefficientPair fields;          ///< of the finest grid
  Correction correction;           ///< r at them
  std::vector<double> prediction;  ///< r M [M][v][u]
  ModelTrial trial;
};

struct ModelSearch {
  std::optional<SimpleFit> accepted;  ///< what the data did not reject, or what was asked for
  std::vector<SimpleFit> rejected;    ///< on the finest grid
  std::vector<ModelTrial> trials;     ///< all, in the order they were made
  /// Error of the data beyond their noise, if the accepted model requires one.
  std::optional<SystematicError> systematic;
  SolveCount solves;  ///< of all grids
};

struct ModelSearchOptions {
  Model asked = Model::automatic;
  bool correct_grid = true;
  std::uint64_t seed = 1;
  ModelError model_error;         ///< of the finest grid
  ModelError coarse_model_error;  ///< of the others
  Backend backend;
};

/// `kappa` [mm] and `mu` [1/mm] are where to start, `correction` is r there on the coarsest grid. A
/// model that the coarse grids reject is not tried on the finer ones, nor fitted to the end there,
/// unless it is asked for. `on_trial` is called before each trial with what is tried.
ModelSearch search_simple_models(const GridLevels& levels, double kappa, double mu,
                                 const Correction& correction, const ModelSearchOptions& options,
                                 const std::function<void(const std::string&)>& on_trial);

}  // namespace kappamu::inverse
