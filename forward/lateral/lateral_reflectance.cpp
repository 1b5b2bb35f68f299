#include "forward/lateral/lateral_reflectance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/error.h"
#include "core/optics.h"
#include "core/shown_text.h"
#include "forward/analytic/layered_mode.h"
#include "forward/analytic/validity.h"
#include "forward/lateral/lateral_diffusion.h"
#include "forward/lateral/slides.h"

namespace kappamu::forward {

namespace {

#include "forward/lateral/lateral_table.inc"

/// Lagrange's weights of the nodes at x.
template <std::size_t n>
std::array<double, n> lagrange(const std::array<double, n>& nodes, double x) {
  std::array<double, n> weights;
  weights.fill(1.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      if (j != i) weights[i] *= (x - nodes[j]) / (nodes[i] - nodes[j]);
    }
  }
  return weights;
}

void expect(double value, double low, double high, const std::string& name) {
  if (value >= low && value <= high) return;
  throw InputError(name + " " + shown_number(value) +
                   " is outside the table of lateral transport, " + shown_number(low) + " to " +
                   shown_number(high));
}

double squared_m(double a, double k) {
  return 3.0 * a + k * k;
}

double k_of(double frequency, double musp) {
  return 2.0 * std::numbers::pi * frequency / musp;
}

// Relative error of a slab by diffusion's ratio: 11 % at a thickness of 1/σs', 2 % at 2/σs' and
// less than Monte Carlo's 0.3 % from 4/σs' on, at μa/σs' of 0.01 and 0.1 alike
// (tests/studies/lateral_slab_test.cpp).
double slab_error(double thickness) {
  return 0.45 * std::exp(-1.4 * thickness);
}

// Relative error of two layers by diffusion's equivalent half-space: nothing where one of them
// decides alone, in proportion to how far their coefficients are apart, and growing with frequency.
// Against Monte Carlo: 0.3 to 1.1 % under even light, 5 to 30 % where 2πf/σs' is 0.9 to 1.5
// (tests/forward/lateral/two_layers_test.cpp).
double layers_error(double share, double k, const LateralLayer& upper, const LateralLayer& lower) {
  const double apart =
      std::abs(std::log(upper.musp / lower.musp)) + std::abs(std::log(upper.mua / lower.mua)) / 4.0;
  return share * (1.0 - share) * apart * (0.05 + 1.2 * k * k / (1.0 + k * k));
}

}  // namespace

LateralReflectance::LateralReflectance(const LateralMedium& medium) : medium_(medium) {
  expect(medium.index, table_index.front(), table_index.back(), "refractive index");
  expect(medium.anisotropy, table_anisotropy.front(), table_anisotropy.back(), "anisotropy");
  if (medium.thickness_mm && !(*medium.thickness_mm > 0.0)) {
    throw InputError("thickness " + shown_number(*medium.thickness_mm) +
                     " mm: a slab is thicker than 0");
  }
  if (medium.cover && medium.thickness_mm) {
    throw InputError("a known layer lies over a half-space; state its thickness alone");
  }
  if (medium.base && !medium.thickness_mm) {
    throw InputError("the layer over a known half-space needs its thickness");
  }
  const auto positive = [](const LateralLayer& layer) {
    return layer.mua > 0.0 && layer.musp > 0.0;
  };
  if ((medium.cover && !(positive(*medium.cover) && medium.cover->thickness_mm > 0.0)) ||
      (medium.base && !positive(*medium.base))) {
    throw InputError("a known layer has absorption, scattering and thickness above 0");
  }
  if (medium.slide_index && (!medium.thickness_mm || medium.base)) {
    throw InputError("glass slides lie on both sides of a slab; state its thickness");
  }
  if (medium.slide_index && !(*medium.slide_index >= 1.0 && *medium.slide_index <= 2.5)) {
    throw InputError("slide index " + shown_number(*medium.slide_index) +
                     ": glass has an index of 1 to 2.5");
  }
  robin_A_ = boundary_constants(medium.index).A;
  surface_A_ = medium.slide_index ? slide_constants(medium.index, *medium.slide_index).A : robin_A_;
  const auto by_g = lagrange(table_anisotropy, medium.anisotropy);
  const auto by_n = lagrange(table_index, medium.index);
  for (std::size_t g = 0; g < by_g.size(); ++g) {
    for (std::size_t n = 0; n < by_n.size(); ++n) {
      for (std::size_t i = 0; i < coefficients_.size(); ++i) {
        coefficients_[i] += by_g[g] * by_n[n] * table_coefficients[g][n][i];
      }
    }
  }
}

LateralValue LateralReflectance::half_space(double a, double k) const {
  // Diffusion D and its logarithmic derivatives.
  const double tau = 1.0 + a, decay = std::sqrt(3.0 * a * tau + k * k), A = 2.0 * robin_A_ / 3.0;
  const double decay_a = 1.5 * (1.0 + 2.0 * a) / decay, decay_k = k / decay;
  const double through = 1.0 + A * decay / tau;
  const double value = 1.0 / ((tau + decay) * through);
  double by_a = -(1.0 + decay_a) / (tau + decay) - A * (decay_a - decay / tau) / (tau * through);
  double by_k = -decay_k / (tau + decay) - A * decay_k / (tau * through);
  // The ratio transport over diffusion, exp(v P(v, q)).
  const LateralPlace at = lateral_place(a, k);
  const auto tv = chebyshev_v(at.v);
  const auto tq = chebyshev_q(at.q);
  double p = 0.0, p_v = 0.0, p_q = 0.0;
  for (int i = 0; i < lateral_orders_v; ++i) {
    double row = 0.0, row_q = 0.0;
    for (int j = 0; j < lateral_orders_q; ++j) {
      const double t = coefficients_[i * lateral_orders_q + j];
      row += t * tq.value[j];
      row_q += t * tq.derivative[j];
    }
    p += tv.value[i] * row;
    p_v += tv.derivative[i] * row;
    p_q += tv.value[i] * row_q;
  }
  const double by_m = (p + at.v * p_v) * at.v_m;
  by_a += by_m * 1.5 / at.m + at.v * p_q * at.q_a;
  by_k += by_m * k / at.m + at.v * p_q * at.q_k;
  const double reflectance = value * std::exp(at.v * p);
  return {reflectance, reflectance * by_a, reflectance * by_k};
}

LateralReflectance::TwoLayers LateralReflectance::two_layers(double frequency, double mua,
                                                             double musp) const {
  const LateralLayer fitted{mua, musp};
  TwoLayers two{fitted, fitted, 0.0, 0.0};
  if (medium_.cover) {
    two.upper = *medium_.cover;
    two.thickness = medium_.cover->thickness_mm;
  } else {
    two.lower = *medium_.base;
    two.thickness = *medium_.thickness_mm;
  }
  // A beam's first collisions fall with depth by μtr, what comes back from there by γ.
  const double transport = two.upper.mua + two.upper.musp;
  const double wave = 2.0 * std::numbers::pi * frequency;
  const double decay = std::sqrt(3.0 * two.upper.mua * transport + wave * wave);
  two.share = -std::expm1(-two.thickness * (transport + decay));
  return two;
}

double LateralReflectance::layered_value(double frequency, double mua, double musp) const {
  const TwoLayers two = two_layers(frequency, mua, musp);
  const auto layer = [](const LateralLayer& of, double thickness) {
    return Layer{1.0 / (3.0 * (of.mua + of.musp)), of.mua, thickness};
  };
  const std::array<Layer, 2> layers{layer(two.upper, two.thickness),
                                    layer(two.lower, std::numeric_limits<double>::infinity())};
  const double wave = 2.0 * std::numbers::pi * frequency;
  const double diffuse = LayeredMode(layers, robin_A_, {wave * wave, 1.0, 0.0}).flux_out_near();
  // The half-space of the same diffuse reflectance, which falls with a.
  const double k = k_of(frequency, two.share * two.upper.musp + (1.0 - two.share) * two.lower.musp);
  constexpr double least = 1e-9, most = 1e3;
  constexpr int halvings = 50;
  double low = std::log(least), high = std::log(most);
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (diffuse_half_space(std::exp(middle), k, robin_A_) > diffuse ? low : high) = middle;
  }
  const double a = std::exp(0.5 * (low + high));
  return half_space(a, k).reflectance * diffuse / diffuse_half_space(a, k, robin_A_);
}

LateralValue LateralReflectance::operator()(double frequency, double mua, double musp) const {
  if (layered()) {
    constexpr double part = 1e-4;
    const double value = layered_value(frequency, mua, musp);
    return {value, (layered_value(frequency, mua * (1.0 + part), musp) - value) / (part * mua),
            (layered_value(frequency, mua, musp * (1.0 + part)) - value) / (part * musp)};
  }
  const double a = mua / musp, k = k_of(frequency, musp);
  const LateralValue half = half_space(a, k);
  LateralValue result{half.reflectance, half.d_mua / musp,
                      -(half.d_mua * a + half.d_musp * k) / musp};
  if (!medium_.thickness_mm) return result;
  const double thickness = *medium_.thickness_mm;
  const auto ratio = [&](double mua_at, double musp_at) {
    return slab_over_half_space(mua_at / musp_at, k_of(frequency, musp_at), robin_A_, surface_A_,
                                thickness * musp_at);
  };
  constexpr double step = 1e-4;
  const double r = ratio(mua, musp);
  result.d_mua =
      r * result.d_mua + half.reflectance * (ratio(mua * (1.0 + step), musp) - r) / (step * mua);
  result.d_musp =
      r * result.d_musp + half.reflectance * (ratio(mua, musp * (1.0 + step)) - r) / (step * musp);
  result.reflectance = r * half.reflectance;
  return result;
}

double LateralReflectance::transmitted(double frequency, double mua, double musp) const {
  const double transport = mua + musp, wave = 2.0 * std::numbers::pi * frequency;
  const std::array<Layer, 1> slab{{{1.0 / (3.0 * transport), mua, *medium_.thickness_mm}}};
  const LayeredMode mode(slab, surface_A_, {wave * wave, 1.0, 0.0});
  const double error = diffusion_validity(musp / transport, *medium_.thickness_mm * transport)
                           .transmitted.value_or(0.0);
  return (mode.flux_out_far() + mode.unscattered_far()) / (1.0 + error);
}

LateralValue LateralReflectance::transmittance(double frequency, double mua, double musp) const {
  check(medium_.thickness_mm && !medium_.base, "light shines through slabs alone");
  constexpr double part = 1e-4;
  const double value = transmitted(frequency, mua, musp);
  return {value, (transmitted(frequency, mua * (1.0 + part), musp) - value) / (part * mua),
          (transmitted(frequency, mua, musp * (1.0 + part)) - value) / (part * musp)};
}

// The validity table is of isotropic scattering at index 1.3: half of its correction is in doubt.
// At g 0.9 diffusion is 10 to 12 % too bright where μa/σs' is 0.1, through 2 and 4/σs', and right
// to 1 % where it is 0.01 (tests/studies/lateral_slab_test.cpp).
double LateralReflectance::transmittance_error(double mua, double musp) const {
  const double transport = mua + musp;
  const double correction = diffusion_validity(musp / transport, *medium_.thickness_mm * transport)
                                .transmitted.value_or(1.0);
  return std::hypot(0.01, 0.5 * correction, mua / musp);
}

double LateralReflectance::relative_error(double frequency, double mua, double musp) const {
  const double a = mua / musp, k = k_of(frequency, musp);
  const double m = std::sqrt(squared_m(a, k));
  const auto above = std::upper_bound(table_m.begin(), table_m.end(), m);
  const std::size_t node = std::min<std::size_t>(above - table_m.begin(), table_m.size() - 1);
  const auto g =
      std::upper_bound(table_anisotropy.begin(), table_anisotropy.end() - 1, medium_.anisotropy) -
      table_anisotropy.begin();
  const double half = std::max(table_error[g][node], table_error[g - 1][node]);
  if (layered()) {
    const TwoLayers two = two_layers(frequency, mua, musp);
    const double mean_musp = two.share * two.upper.musp + (1.0 - two.share) * two.lower.musp;
    return std::hypot(half,
                      layers_error(two.share, k_of(frequency, mean_musp), two.upper, two.lower));
  }
  if (!medium_.thickness_mm) return half;
  return std::hypot(half, slab_error(*medium_.thickness_mm * musp));
}

bool LateralReflectance::covers(double frequency, double mua, double musp) {
  return squared_m(mua / musp, k_of(frequency, musp)) <= lateral_largest_m * lateral_largest_m;
}

}  // namespace kappamu::forward
