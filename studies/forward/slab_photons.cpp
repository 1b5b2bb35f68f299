#include "studies/forward/slab_photons.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/error.h"
#include "forward/lateral/slides.h"

namespace kappamu::studies {

namespace {

/// Uniform in (0, 1): the standard library's distributions differ between implementations.
class Stream {
 public:
  explicit Stream(std::uint64_t seed) : engine_(seed) {}
  double operator()() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

double henyey_greenstein(double g, double u) {
  if (std::abs(g) < 1e-6) return 2.0 * u - 1.0;
  const double ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
  return (1.0 + g * g - ratio * ratio) / (2.0 * g);
}

struct Exit {
  double reflected = 0.0, transmitted = 0.0;
};

class Tracer {
 public:
  Tracer(const OpticalSlab& slab, std::uint64_t seed)
      : slab_(slab),
        sigma_s_(slab.sigma_s_prime / (1.0 - slab.anisotropy)),
        sigma_t_(sigma_s_ + slab.sigma_a),
        random_(seed) {}

  Exit photon(Incidence incidence) {
    // Lambertian light has cos² uniform.
    const double cos_outside = incidence == Incidence::normal ? 1.0 : std::sqrt(random_());
    const double n = slab_.n_sample;
    double cosine = std::sqrt(1.0 - (1.0 - cos_outside * cos_outside) / (n * n));
    if (random_() < reflectance(cosine)) return {1.0, 0.0};
    double z = 0.0, weight = 1.0;
    for (;;) {
      const double path = sigma_t_ > 0.0 ? -std::log(random_()) / sigma_t_
                                         : std::numeric_limits<double>::infinity();
      const double to_surface = cosine > 0.0   ? (slab_.thickness - z) / cosine
                                : cosine < 0.0 ? -z / cosine
                                               : path * 2.0;
      if (path >= to_surface) {
        if (random_() >= reflectance(std::abs(cosine))) {
          return cosine > 0.0 ? Exit{0.0, weight} : Exit{weight, 0.0};
        }
        z = cosine > 0.0 ? slab_.thickness : 0.0;
        cosine = -cosine;
        continue;
      }
      z += path * cosine;
      weight *= sigma_s_ / sigma_t_;
      if (weight < 1e-3) {  // roulette: one in ten goes on with tenfold weight
        if (random_() >= 0.1) return {};
        weight *= 10.0;
      }
      const double turn = henyey_greenstein(slab_.anisotropy, random_());
      const double azimuth = std::cos(2.0 * std::numbers::pi * random_());
      cosine = cosine * turn +
               std::sqrt(std::max(0.0, (1.0 - cosine * cosine) * (1.0 - turn * turn))) * azimuth;
    }
  }

 private:
  double reflectance(double cosine) const {
    return forward::slide_reflectance(slab_.n_sample, slab_.n_slide, cosine);
  }
  OpticalSlab slab_;
  double sigma_s_, sigma_t_;
  Stream random_;
};

}  // namespace

SlabTotals trace_slab(const OpticalSlab& slab, Incidence incidence, std::uint64_t photons,
                      std::uint64_t seed) {
  if (!(slab.n_sample >= 1.0 && slab.n_slide >= 1.0 && slab.thickness > 0.0 &&
        slab.sigma_a >= 0.0 && slab.sigma_s_prime >= 0.0 && std::abs(slab.anisotropy) < 1.0)) {
    throw InputError(
        "slab: indices must be at least 1, the thickness positive, coefficients not negative and g "
        "between -1 and 1");
  }
  check(photons >= 2, "trace_slab: at least two photons");
  Tracer tracer(slab, seed);
  double r1 = 0.0, r2 = 0.0, t1 = 0.0, t2 = 0.0;
  for (std::uint64_t i = 0; i < photons; ++i) {
    const Exit exit = tracer.photon(incidence);
    r1 += exit.reflected;
    r2 += exit.reflected * exit.reflected;
    t1 += exit.transmitted;
    t2 += exit.transmitted * exit.transmitted;
  }
  const auto n = static_cast<double>(photons);
  const auto error = [n](double first, double second) {
    return std::sqrt(std::max(0.0, second / n - first / n * (first / n)) / (n - 1.0));
  };
  return {r1 / n, t1 / n, error(r1, r2), error(t1, t2)};
}

}  // namespace kappamu::studies
