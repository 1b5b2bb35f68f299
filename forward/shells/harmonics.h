// Real spherical harmonics ([K] eq. 6), without the Condon-Shortley phase: Y_1 = √(3/4π)·(y, z, x).
// The printed K_l^m is right for m ≥ 0 alone: at m < 0 it must take |m|, as here.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace kappamu::forward::shells {

inline constexpr int most_bands = 6;

/// Number of functions of bands 0 … bands−1; Y_l^m stands at l(l+1) + m.
constexpr int harmonics_in(int bands) {
  return bands * bands;
}

/// Y_l^m(direction), of unit length.
Eigen::VectorXd harmonics(int bands, const Eigen::Vector3d& direction);

/// The coefficients of a function on the sphere, turned with it. Each band is written as 2l+1 zonal
/// lobes about fixed axes, and the axes are turned (Nowrouzezahrai et al. 2012): no matrix of
/// rotation is made.
class Turner {
 public:
  explicit Turner(int bands);
  /// Columns are functions: what was seen along d is then seen along `rotation`·d.
  Eigen::MatrixXd turned(const Eigen::MatrixXd& coefficients,
                         const Eigen::Matrix3d& rotation) const;

 private:
  int bands_;
  std::vector<Eigen::Vector3d> axes_;  ///< band l uses 2l+1 of them
  std::vector<Eigen::MatrixXd> lobes_of_band_;
};

}  // namespace kappamu::forward::shells
