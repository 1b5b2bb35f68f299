// One body on one set of panels: from lights to fluence, [T] (5.3) with the sources of theory.md.
#pragma once

#include "core/optics.h"
#include "forward/boundary_integral/beam_source.h"

namespace kappamu::forward::boundary_integral {

struct BoundaryAnswer {
  std::vector<Eigen::VectorXd> fluence;  ///< [light][panel]
  std::vector<BeamPowers> beams;         ///< per light
  int iterations = 0;
  bool converged = true;  ///< every linear system is solved
  double setup_seconds = 0.0, seconds = 0.0;
  std::size_t bytes = 0;  ///< kept for the equation's sums
};

/// Solves ½ φ + ∫ (∂G/∂n_y + G/(2Aκ)) φ dA = ∫ G S/κ dV + ∫ G q/(2Aκ) dA at the panels' centroids
/// for every light; `panels` (fitted_to_boxes()) cover the problem's mesh. `accuracy`: relative
/// 2-norm error of the fluence that sums and the linear solver leave.
BoundaryAnswer solve_boundary(const ObjectProblem& problem, const BoundaryConstants& constants,
                              const std::vector<Panel>& panels, double accuracy);

/// q of a light's diffuse irradiance, per triangle.
std::vector<double> boundary_source(const ObjectLight& light, const BoundaryConstants& constants);

}  // namespace kappamu::forward::boundary_integral
