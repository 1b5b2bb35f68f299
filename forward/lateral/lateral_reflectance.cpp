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
#include "forward/lateral/lateral_diffusion.h"
#include "forward/lateral/lateral_stack.h"
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

// Of layers by spherical harmonics: within 0.4 % of the table's half-spaces at all g and up to
// 0.4 /mm (layered_transport_test.cpp).
constexpr double stack_error = 0.004;

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
  if (medium.thickness_mm || medium.cover) stack_ = std::make_shared<LateralStack>(medium);
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

LateralValue LateralReflectance::operator()(double frequency, double mua, double musp) const {
  if (layered()) return stack_->reflectance(frequency, mua, musp);
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

LateralValue LateralReflectance::transmittance(double frequency, double mua, double musp) const {
  check(medium_.thickness_mm && !medium_.base, "light shines through slabs alone");
  return stack_->transmittance(frequency, mua, musp);
}

double LateralReflectance::transmittance_error() const {
  return stack_error;
}

double LateralReflectance::relative_error(double frequency, double mua, double musp) const {
  if (layered()) return stack_error;
  const double a = mua / musp, k = k_of(frequency, musp);
  const double m = std::sqrt(squared_m(a, k));
  const auto above = std::upper_bound(table_m.begin(), table_m.end(), m);
  const std::size_t node = std::min<std::size_t>(above - table_m.begin(), table_m.size() - 1);
  const auto g =
      std::upper_bound(table_anisotropy.begin(), table_anisotropy.end() - 1, medium_.anisotropy) -
      table_anisotropy.begin();
  const double half = std::max(table_error[g][node], table_error[g - 1][node]);
  if (!medium_.thickness_mm) return half;
  return std::hypot(half, slab_error(*medium_.thickness_mm * musp));
}

bool LateralReflectance::covers(double frequency, double mua, double musp) {
  return squared_m(mua / musp, k_of(frequency, musp)) <= lateral_largest_m * lateral_largest_m;
}

}  // namespace kappamu::forward
