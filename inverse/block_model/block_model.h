// What kind of block a fit was asked for, and what it chose.
#pragma once

#include <string>
#include <vector>

#include "core/names.h"

namespace kappamu::inverse {

enum class Model {
  automatic,    ///< the simplest that the data do not reject
  homogeneous,  ///< one κ, one μ
  layered,      ///< one of each per layer across the light
  volume        ///< one of each per voxel
};
inline constexpr Names<Model, 4> model_names{{{"auto", Model::automatic},
                                              {"homogeneous", Model::homogeneous},
                                              {"layered", Model::layered},
                                              {"volume", Model::volume}}};
inline std::string to_string(Model model) {
  return name_of(model_names, model);
}

struct LayeredMedium {
  /// First slice of each layer along the light's axis, ascending; the first is 0. A layer ends
  /// where the next begins.
  std::vector<int> first;
  std::vector<double> log_kappa;  ///< of each layer, κ in mm
  std::vector<double> log_mu;     ///< of each layer, μ in 1/mm

  int layers() const { return static_cast<int>(first.size()); }
};

/// One model held against the data.
struct ModelTrial {
  Model model = Model::volume;
  int level = 0;   ///< grid, 0 = finest
  int layers = 0;  ///< 0 for a volume
  double chi2_per_value = 0.0;
  double coherent =
      0.0;  ///< share of it that neighbouring pixels have in common (model_evidence.h)
  double coherent_limit = 0.0;  ///< what noise and the model's own error explain of that
  bool rejected = true;
};

struct ModelChoice {
  Model model = Model::volume;
  int layers = 0;      ///< 0 for a volume
  std::string reason;  ///< one sentence
  /// Error of the data that neighbouring pixels share and no structure explains
  /// (systematic_error.h), relative to the values; 0 where none was found.
  double systematic = 0.0;
  double systematic_length = 0.0;  ///< its correlation length [pixels]
  std::vector<ModelTrial> trials;
};

}  // namespace kappamu::inverse
