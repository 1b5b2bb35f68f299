// Light of collimated beams in the boundary integral equation: the free-space potential of their
// first collisions.
#pragma once

#include <Eigen/Core>

#include "forward/boundary_integral/panels/panel.h"
#include "forward/object_model.h"

namespace kappamu::forward::boundary_integral {

/// Where the power of a light's beams goes, after Fresnel [mm²]; the last three sum to the first.
struct BeamPowers {
  double entering = 0.0;
  double scattered = 0.0;    ///< the source of diffuse light
  double absorbed = 0.0;     ///< at the first collision
  double unscattered = 0.0;  ///< left without one
};

/// Points along the beams that stand for their collisions. Each chord is cut into intervals, graded
/// towards both ends, the first half a panel long; an interval has Gauss points in the share of the
/// light that has collided, and its power is exact.
struct BeamSource {
  std::vector<Eigen::Vector3d> at;  ///< [mm]
  std::vector<double> power;        ///< scattered [mm²]
  BeamPowers powers;
};

/// `panels` cover the problem's mesh. Throws InputError where a beam meets the surface from inside.
BeamSource beam_source(const ObjectProblem& problem, const std::vector<Beam>& beams,
                       const std::vector<Panel>& panels);

/// ∫ G S/κ dV at the panels' centroids; the part of a point of the source near a panel is its mean
/// over it, exactly. `order`: sum_order().
Eigen::VectorXd beam_potentials(const BeamSource& source, const std::vector<Panel>& panels,
                                const Coefficients& medium, int order);

}  // namespace kappamu::forward::boundary_integral
