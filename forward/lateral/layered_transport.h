// Transport in a stack of layers under light that varies as cos 2πf x across it, by spherical
// harmonics (Liemert and Kienle, Opt. Lett. 37, 4158, 2012, for a half-space; layers as Phillips
// and Jacques, J. Opt. Soc. Am. A 26, 2147, 2009, have them without lateral light). Where diffusion
// takes the radiance for linear in direction, P_N takes polynomials of odd degree N.
//
// Henyey-Greenstein scattering, its forward peak g^(N+1) taken for unscattered (delta-M, Wiscombe
// 1977). The beam's first collisions are the source, Marshak's conditions with Fresnel's reflection
// close the surfaces, and all layers have one refractive index. Within a layer the solution is a
// sum of exponentials of the depth, the eigenvectors of a matrix of 25 rows (N = 9).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kappamu::forward {

struct TransportLayer {
  double mua = 0.0;           ///< μa [1/mm], ≥ 0
  double musp = 0.0;          ///< σs' [1/mm], > 0
  double thickness_mm = 0.0;  ///< > 0; infinite for the last layer of a half-space
};

/// Light that leaves through the lit and through the far side, over light that entered.
struct LayeredLight {
  double reflectance = 0.0;
  double transmittance = 0.0;  ///< unscattered light too; 0 of a half-space
};

class LayeredTransport {
 public:
  /// `slide_index`: of clear glass on both surfaces. `order` N is odd.
  LayeredTransport(double index, double anisotropy, std::optional<double> slide_index = {},
                   int order = 9);

  /// At spatial frequency f [1/mm] ≥ 0. A millisecond or two.
  LayeredLight operator()(std::span<const TransportLayer> layers, double frequency) const;

 private:
  struct Harmonic {
    int l, m;
  };
  using Harmonics = std::vector<Harmonic>;
  struct Modes;
  struct Ends;

  Eigen::MatrixXd across(const Harmonics& list) const;
  Modes modes_of(const TransportLayer& layer, double wave) const;
  Ends ends_at(const Modes& modes, double thickness, double depth, double beam) const;

  double anisotropy_;
  int order_;
  Harmonics even_, odd_;                      ///< by the parity of l + m
  Eigen::MatrixXd along_;                     ///< s_z between even and odd
  Eigen::MatrixXd across_even_, across_odd_;  ///< s_x among even, and among odd
  /// Over the inner hemisphere: ∫ Y_odd (1 − R) Y_even and ∫ Y_odd (1 + R) Y_odd.
  Eigen::MatrixXd escape_even_, escape_odd_;
};

}  // namespace kappamu::forward
