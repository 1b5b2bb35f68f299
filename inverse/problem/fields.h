// The unknowns of a fit, log κ and log μ of every voxel, and the medium that they are.
#pragma once

#include <vector>

#include "forward/medium_space.h"

namespace kappamu::inverse {

using forward::CoefficientPair;
using forward::MediumSpace;

/// e^log of every element.
std::vector<double> exponential(const std::vector<double>& log);

Medium to_medium(const CoefficientPair& fields, const GridShape& shape);
/// And back: the logarithms of every voxel.
CoefficientPair to_fields(const Medium& medium);

}  // namespace kappamu::inverse
