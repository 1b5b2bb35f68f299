// A slab by lateral transport beside the photon walk of studies/forward, which shares no code with
// the table: even light, slabs from two mean free paths to a half-space.
#include <gtest/gtest.h>

#include <cmath>

#include "core/optics.h"
#include "forward/lateral/lateral_reflectance.h"
#include "forward/lateral/slides.h"
#include "studies/forward/slab_photons.h"

namespace kappamu::studies {
namespace {

TEST(LateralSlab, IsThePhotonsSlab) {
  constexpr double index = 1.4, g = 0.9, musp = 1.0;
  const double specular = 1.0 - boundary_constants(index).normal_transmittance;
  for (const double mua : {0.01, 0.1}) {
    for (const double thickness : {2.0, 4.0, 8.0, 40.0}) {
      const SlabTotals walk =
          trace_slab({index, 1.0, thickness, mua, musp, g}, Incidence::normal, 20000, 23);
      const double entered = 1.0 - specular;
      const double photons = (walk.reflected - specular) / entered;
      const forward::LateralReflectance slab({index, g, thickness});
      const double ours = slab(0.0, mua, musp).reflectance;
      const double error =
          std::hypot(walk.reflected_error / entered, ours * slab.relative_error(0.0, mua, musp));
      EXPECT_LT(std::abs(photons - ours), 3.5 * error)
          << "mua " << mua << " thickness " << thickness << ": " << photons << " " << ours;
    }
  }
}

/// Both sides of a slab, bare and between slides.
TEST(LateralSlab, ShinesThroughAsThePhotonsDo) {
  constexpr double index = 1.4, g = 0.9, musp = 1.0;
  for (const double slide : {1.0, 1.5}) {
    const double specular = forward::slide_reflectance(index, slide, 1.0);
    for (const double mua : {0.01, 0.1}) {
      for (const double thickness : {2.0, 4.0, 8.0}) {
        const SlabTotals walk =
            trace_slab({index, slide, thickness, mua, musp, g}, Incidence::normal, 20000, 29);
        forward::LateralMedium medium{index, g, thickness};
        medium.slide_index = slide;
        const forward::LateralReflectance slab(medium);
        const double entered = 1.0 - specular;
        const double reflected = slab(0.0, mua, musp).reflectance;
        const double through = slab.transmittance(0.0, mua, musp).reflectance;
        EXPECT_LT(std::abs((walk.reflected - specular) / entered - reflected),
                  3.0 * std::hypot(walk.reflected_error / entered,
                                   reflected * slab.relative_error(0.0, mua, musp)))
            << "slide " << slide << " mua " << mua << " thickness " << thickness << ": "
            << (walk.reflected - specular) / entered << " " << reflected;
        EXPECT_LT(std::abs(walk.transmitted / entered - through),
                  3.0 * std::hypot(walk.transmitted_error / entered,
                                   through * slab.transmittance_error()))
            << "slide " << slide << " mua " << mua << " thickness " << thickness << ": "
            << walk.transmitted / entered << " " << through;
      }
    }
  }
}

}  // namespace
}  // namespace kappamu::studies
