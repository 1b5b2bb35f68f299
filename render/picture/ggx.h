// Reflection at a rough dielectric surface: the GGX distribution of facets with Smith's masking
// (Walter et al. 2007; Heitz 2014), α being `roughness`. Cosines are to the surface's normal; light
// reflected more than once is left out.
#pragma once

#include <Eigen/Core>

namespace kappamu::render {

class Ggx {
 public:
  /// A mirror where roughness < 1e-3: it has a direction, not a density.
  Ggx(double eta, double roughness) : eta_(eta), alpha_(roughness) {}
  bool mirror() const { return alpha_ < 1e-3; }

  /// f_r · cosθ_light [1/sr]. In a frame whose z axis is the normal; both directions point away
  /// from the surface.
  double reflectance(const Eigen::Vector3d& view, const Eigen::Vector3d& light) const;
  /// A direction of light, drawn by the facets that `view` sees (Heitz 2018), or the mirror's.
  Eigen::Vector3d sample(const Eigen::Vector3d& view, double u, double v) const;
  /// Of what sample() draws [1/sr]; zero below the surface.
  double density(const Eigen::Vector3d& view, const Eigen::Vector3d& light) const;

 private:
  double facets(double cosine) const;
  double lambda(double cosine) const;
  double eta_, alpha_;
};

}  // namespace kappamu::render
