// Light on a block beyond irradiance at normal incidence: an oblique beam, and isotropic points
// inside.
//
// Positions and directions are in the sample frame (core/grid.h). Light that has not scattered yet
// is marched as in objects (forward/light), reflected and refracted at every face that it meets;
// what it scatters first in each voxel is the source of the diffusion equation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Radiates evenly in all directions.
struct PointSource {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();  ///< inside the block
  double power = 1.0;                                     ///< [mm² times the unit of irradiance]
};

struct LightGeometry {
  /// Of the collimated beam in air, any length; normal incidence where unset. Irradiance is per
  /// area of the face, the cosine included. First-collision source only.
  std::optional<Eigen::Vector3d> direction{};
  /// The last patterns are one point each, in this order; their irradiance is zero.
  std::vector<PointSource> points{};

  bool plain() const { return !direction && points.empty(); }
};

/// Throws InputError naming what is wrong: a direction that does not lead into the lit face or goes
/// with the boundary source, a point outside the block, a power that is not positive, more points
/// than patterns, or points under wang2008.
void validate(const GridSetup& setup, const LightGeometry& light, int patterns);

/// The beam just below the lit face, by Snell's and Fresnel's laws.
struct EnteredBeam {
  Eigen::Vector3d direction;  ///< of unit length
  double transmittance = 1.0;
};
EnteredBeam enter_beam(const GridSetup& setup, const LightGeometry& light);

/// Power that enters with each pattern, a point's being its own.
std::vector<double> entering_power(const GridSetup& setup, const LightGeometry& light,
                                   std::span<const double> irradiance, int patterns);

/// The right-hand sides of the grid's equations for what GridSolver::light_source() does not know:
/// the oblique beam and the points. Powers are per pattern.
struct LightLoad {
  std::vector<double> source;       ///< [pattern][z][y][x]
  std::vector<double> entering;     ///< 0 for patterns of normal incidence
  std::vector<double> absorbed;     ///< by the first collisions
  std::vector<double> unscattered;  ///< leaves without a collision, by any face
};
/// A point is shared among the eight voxels around it, trilinearly: exact in its first moment from
/// half a voxel off the faces on.
LightLoad light_load(const GridSetup& setup, const Medium& medium, const LightGeometry& light,
                     std::span<const double> irradiance, int patterns);

}  // namespace kappamu::forward
