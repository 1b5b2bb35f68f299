// One object on one octree: from lights to exitances.
#pragma once

#include "core/optics.h"
#include "forward/embedded/beams.h"
#include "forward/embedded/multigrid_cg.h"

namespace kappamu::forward::embedded {

struct Discretisation {
  Octree tree;
  CutMesh mesh;
  std::vector<Coefficients> coefficients;  ///< per cube
  Hierarchy hierarchy;

  Discretisation(Octree octree, CutMesh cut, const ObjectMedium& medium, double A);
};

struct Answer {
  std::vector<std::vector<double>> fluence;   ///< [light][unknown]
  std::vector<std::vector<double>> exitance;  ///< [light][triangle]
  std::vector<ObjectBalance> balance;
  CgReport report;
};

/// Relative residual of the linear systems: far below any error of the discretisation. The powers
/// balance whatever it is.
inline constexpr double linear_tolerance = 1e-6;

Answer answer(const Discretisation& discretisation, const ObjectProblem& problem,
              const BoundaryConstants& constants, double tolerance = linear_tolerance);

/// Of diffuse light from outside, the share that enters: η² (1 − R_φ), by reciprocity.
double diffuse_transmittance(const BoundaryConstants& constants);

}  // namespace kappamu::forward::embedded
