// A homogeneous block on any pixels of one face, by its lateral modes: thousands of times faster
// than a solve on a grid, whose resolution does not enter, and with open sides as well as mirrors.
//
// With ∂φ/∂n = −g φ at both ends of an axis of length X, g = 1/(2Aκ) (open) or 0 (mirror), its
// modes are cos(αx − ψ), tan ψ = g/α, αX = jπ + 2ψ. Those that the pixels resolve are summed: what
// is finer decays within a pixel's edge of the lit face. Those that arrive at a seen face across
// the light with less than 1e-12 of the uniform mode's response are left out.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "forward/analytic/layered_mode.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Positions along u and v of a face, every one with every other.
struct FacePixels {
  std::vector<int> u, v;
};

class HomogeneousBlock {
 public:
  /// `irradiance` [M][v][u] on the lit face, before Fresnel; kept by reference.
  HomogeneousBlock(const GridSetup& setup, Face seen, const std::vector<double>& irradiance,
                   FacePixels pixels);
  HomogeneousBlock(const GridSetup&, Face, std::vector<double>&&, FacePixels) = delete;

  /// Exitance of the seen face for κ [mm] > 0 and μ [1/mm] ≥ 0, [M][v][u] of the pixels.
  std::vector<double> exitance(double kappa, double mu);

 private:
  /// Orthonormal modes of one axis.
  struct Axis {
    std::vector<double> wavenumber;  ///< α [1/mm]
    Eigen::MatrixXd mean;            ///< over each voxel [voxel][mode]
    Eigen::VectorXd first, last;     ///< at both ends [mode]
  };
  static Axis modes(int voxels, double voxel_mm, double g);
  void set_sides(double g);
  /// waves_ of at least so many modes along u and v.
  void set_waves(Eigen::Index u, Eigen::Index v);
  std::vector<double> depths() const;
  double response(const LayeredMode& mode, double depth) const;
  Eigen::MatrixXd through_side(const std::vector<Eigen::MatrixXd>& filters,
                               const Eigen::MatrixXd& waves) const;

  GridSetup setup_;
  Face seen_;
  FacePixels pixels_;
  const std::vector<double>* irradiance_;
  double q_ = 0.0, robin_A_ = 0.0, scale_ = 1.0;
  double beam_ = 0.0, reflectance_ = 0.0, apart_ = 0.0;
  double g_ = -1.0;  ///< what the modes were made for; negative: none yet
  std::array<Axis, 2> axis_;
  /// Of each pattern's irradiance [mode of u][mode of v], as many modes as were asked for.
  std::vector<Eigen::MatrixXd> waves_;
};

}  // namespace kappamu::forward
