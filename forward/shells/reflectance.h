// What a hair sends to the eye of light that comes along a direction, from its tangent alone:
// light per solid angle, over ∫ = 1 of a white hair under even light.
//
// Kajiya and Kay 1989: p = (1−s) sin(t,l)/π² + s (sin(t,l) sin(t,v) − cos(t,l) cos(t,v))^n / N.
// Marschner et al. 2003: in place of the second, their lobes R, TT and TRT: Gaussians of the
// longitudinal angle, their azimuths fitted as in Karis 2016, over N. N depends on (t,v) and makes
// each lobe's sum integrate to one over the light's directions; it is tabulated.
#pragma once

#include <Eigen/Core>
#include <array>

namespace kappamu::forward::shells {

enum class HairModel {
  even,  ///< 1/4π: the light that arrives, as [K] shows it
  kajiya_kay,
  marschner
};

class HairReflectance {
 public:
  /// `shine`: s, 0 to 1.
  explicit HairReflectance(HairModel model, double shine = 0.3);

  /// Directions of unit length point from the hair to light and eye. `colour`, 0 to 1, is that of
  /// light that has crossed the hair once [1/sr].
  Eigen::Array3d towards(const Eigen::Vector3d& tangent, const Eigen::Vector3d& light,
                         const Eigen::Vector3d& eye, const Eigen::Array3d& colour) const;

  static constexpr int samples = 64;
  HairModel model() const { return model_; }
  double shine() const { return shine_; }
  /// N over |cos(t,v)|, 0 to 1.
  const std::array<double, samples + 1>& norms() const { return norm_; }

 private:
  Eigen::Array3d lobes(double light, double eye, double azimuth,
                       const Eigen::Array3d& colour) const;
  double norm(double eye) const;

  HairModel model_;
  double shine_;
  std::array<double, samples + 1> norm_{};
};

}  // namespace kappamu::forward::shells
