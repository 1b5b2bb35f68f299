#include "forward/lateral/slides.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kappamu::forward {

namespace {

/// Intensity reflectances {parallel, perpendicular} between two clear media.
std::array<double, 2> fresnel_pair(double n1, double cos1, double n2, double cos2) {
  const double p = (n1 * cos2 - n2 * cos1) / (n1 * cos2 + n2 * cos1);
  const double s = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
  return {p * p, s * s};
}

}  // namespace

double slide_reflectance(double n_sample, double n_slide, double cos_sample) {
  const double sine = n_sample * std::sqrt(std::max(0.0, 1.0 - cos_sample * cos_sample));
  if (sine >= 1.0) return 1.0;  // total reflection, in the slide or before it
  const double cos_air = std::sqrt(1.0 - sine * sine);
  if (n_slide == 1.0) {
    const auto r = fresnel_pair(n_sample, cos_sample, 1.0, cos_air);
    return 0.5 * (r[0] + r[1]);
  }
  const double in_slide = sine / n_slide;
  if (in_slide >= 1.0) return 1.0;
  const double cos_slide = std::sqrt(1.0 - in_slide * in_slide);
  const auto first = fresnel_pair(n_sample, cos_sample, n_slide, cos_slide);
  const auto second = fresnel_pair(n_slide, cos_slide, 1.0, cos_air);
  double sum = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    sum += (first[k] + second[k] - 2.0 * first[k] * second[k]) / (1.0 - first[k] * second[k]);
  }
  return 0.5 * sum;
}

BoundaryConstants slide_constants(double n_sample, double n_slide) {
  // By the midpoint rule: slides have corners at two critical angles, and 1e-6 is enough.
  constexpr int points = 20000;
  double r_phi = 0.0, r_j = 0.0;
  for (int i = 0; i < points; ++i) {
    const double c = (i + 0.5) / points;
    const double reflected = slide_reflectance(n_sample, n_slide, c) / points;
    r_phi += 2.0 * c * reflected;
    r_j += 3.0 * c * c * reflected;
  }
  BoundaryConstants constants;
  constants.eta = n_sample;
  constants.r_phi = r_phi;
  constants.r_j = r_j;
  constants.A = (1.0 + r_j) / (1.0 - r_phi);
  constants.normal_transmittance = 1.0 - slide_reflectance(n_sample, n_slide, 1.0);
  return constants;
}

}  // namespace kappamu::forward
