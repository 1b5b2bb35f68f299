// Which weight of the path is the right one, by what was seen along it on the finest grid.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "inverse/problem/adjoint.h"

namespace kappamu::inverse {

enum class WeightRule {
  discrepancy,  ///< the first at which χ² per value is the noise's (Morozov)
  l_curve,      ///< where log R against log χ² bends most (Hansen & O'Leary 1993)
  held_out      ///< where χ² under light the fit does not see is least
};
std::string to_string(WeightRule rule);

/// One weight, minimised.
struct PathPoint {
  double weight = 0.0;                  ///< α
  double chi2 = 0.0;                    ///< per datum fitted
  double roughness = 0.0;               ///< R
  std::optional<double> held_out_chi2;  ///< per datum held out
  CoefficientPair fields;               ///< empty where it can no longer be chosen
};

struct WeightDecision {
  std::size_t chosen = 0;  ///< best so far
  bool done = false;       ///< lower weights will not be better
};

/// For l_curve and held_out; `path` from strong to weak weights, not empty. L-curve: the corner is
/// an inner point, known once two lower weights bend less. Held out: done at the first weight that
/// does not lower its χ² by at least `least_relief` of itself.
WeightDecision choose_weight(WeightRule rule, std::span<const PathPoint> path, double least_relief);

}  // namespace kappamu::inverse
