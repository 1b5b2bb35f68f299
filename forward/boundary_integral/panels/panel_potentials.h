// Potentials of a panel with unit density under G = e^−λr/(4πr), [T] 5.2.2 and appendix B for any
// point instead of the panel's own centroid.
#pragma once

#include "forward/boundary_integral/panels/panel.h"

namespace kappamu::forward::boundary_integral {

struct PanelPotentials {
  double single_layer = 0.0;  ///< ∫ G(x, y) dA [mm]
  double double_layer = 0.0;  ///< ∫ ∂G/∂n_y dA, dimensionless; in the panel's plane its mean, 0
};

/// In polar coordinates about x's foot on the plane both integrands have antiderivatives along the
/// radius, which leaves integrals along the edges. Those of λ = 0 are closed forms (Wilton et al.
/// 1984); what λ adds is smooth after t = P sinh s, P the distance to the edge's line, and is
/// integrated by Gauss points. Error below 1e-6 of the single layer and 1e-6 of a full turn for
/// panels up to 1/λ in radius, at any distance and any shape. `decay` λ ≥ 0 [1/mm].
PanelPotentials panel_potentials(const Panel& panel, const Eigen::Vector3d& x, double decay);

}  // namespace kappamu::forward::boundary_integral
