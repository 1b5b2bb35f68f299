// Single and double layers on panels, by collocation at their centroids: near panels exactly
// (panel_potentials.h), others by three points, all in linear time (fast_sum.h).
#pragma once

#include "forward/boundary_integral/panels/panel.h"
#include "forward/boundary_integral/summation/fast_sum.h"

namespace kappamu::forward::boundary_integral {

/// Panels in a box of the sum that is not split.
inline constexpr int leaf_panels = 60;

/// Within this many radii of a panel its potentials are exact. Beyond, its three points are in
/// error by less than 1e-3 of a potential that is small itself.
inline constexpr double near_radii = 3.0;

/// The panels, those split that are too large for the box they lie in: where small panels lie
/// beside large ones. FastSum asks for it.
std::vector<Panel> fitted_to_boxes(std::vector<Panel> panels);

struct Layers {
  double decay = 0.0;         ///< λ [1/mm]
  double single_layer = 0.0;  ///< factor of ∫ G u dA [1/mm]
  double double_layer = 0.0;  ///< factor of ∫ ∂G/∂n_y u dA
  int order = 6;              ///< sum_order()
};

/// u per panel ↦ single_layer ∫ G u dA + double_layer ∫ ∂G/∂n_y u dA at every centroid; on its own
/// panel the double layer is its principal value, 0. `panels` (fitted_to_boxes()) must outlive it.
FastSum layer_sum(const std::vector<Panel>& panels, const Layers& layers);

}  // namespace kappamu::forward::boundary_integral
