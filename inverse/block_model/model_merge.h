// As few layers as the data need.
#pragma once

#include <Eigen/Core>

#include "inverse/block_model/model_layers.h"

namespace kappamu::inverse {

/// Neighbouring layers of `medium` joined, most alike first, while that is expected to raise χ² by
/// no more than `allowance` altogether. `normal`: JᵀWJ with respect to log κ of the layers, then
/// log μ, at a minimum of χ². To second order; fit the result anew.
LayeredMedium merge_layers(const LayeredMedium& medium, const Eigen::MatrixXd& normal,
                           double allowance);

}  // namespace kappamu::inverse
