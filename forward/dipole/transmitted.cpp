#include "forward/dipole/transmitted.h"

#include <string>

#include "core/error.h"
#include "core/optics.h"

namespace kappamu::forward::dipole {

std::vector<double> transmitted(const Surface& surface, double eta, const ObjectLight& light) {
  const BoundaryConstants constants = boundary_constants(eta);
  const double lambertian = eta * eta * (1.0 - constants.r_phi);
  std::vector<double> irradiance(surface.size(), 0.0);
  for (std::size_t t = 0; t < light.diffuse.size(); ++t)
    irradiance[t] = lambertian * light.diffuse[t];
  for (const Beam& beam : light.beams) {
    const auto t = static_cast<std::size_t>(beam.triangle);
    const double cosine = -beam.direction.dot(surface.normal[t]);
    if (cosine <= 0.0) {
      throw InputError("a beam meets triangle " + std::to_string(beam.triangle) +
                       " from inside; dipole models take light from outside only: take embedded, "
                       "montecarlo or auto where a light is inside an object");
    }
    irradiance[t] += (1.0 - fresnel_external(eta, cosine)) * beam.power / surface.area[t];
  }
  return irradiance;
}

}  // namespace kappamu::forward::dipole
