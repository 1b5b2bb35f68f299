// The functions by which a small table holds transport over diffusion. With m² = 3a + k² and
// h = k²/(1 + k²/10),
//
//     R = D exp(v Σ t_ij T_i(v) T_j(q)),   v = m/(m + 2),   q = 3a/(3a + h),
//
// D diffusion's reflectance and T Chebyshev's polynomials: smooth in v and q, where R itself has a
// cone at a = k = 0, and 1 where nothing is absorbed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace kappamu::forward {

inline constexpr int lateral_orders_v = 8, lateral_orders_q = 6;
inline constexpr double lateral_largest_m = 9.0;
/// t_ij at [i * lateral_orders_q + j].
using LateralCoefficients = std::array<double, lateral_orders_v * lateral_orders_q>;

/// T_0 ... T_{n-1} and their derivatives at x in [low, high].
template <int n>
struct Chebyshev {
  std::array<double, n> value{}, derivative{};
  Chebyshev(double x, double low, double high) {
    const double scale = 2.0 / (high - low), t = scale * (x - low) - 1.0;
    value[0] = 1.0;
    value[1] = t;
    derivative[1] = scale;
    for (int i = 2; i < n; ++i) {
      value[i] = 2.0 * t * value[i - 1] - value[i - 2];
      derivative[i] = 2.0 * (scale * value[i - 1] + t * derivative[i - 1]) - derivative[i - 2];
    }
  }
};

/// v and q of a point, and q's derivatives.
struct LateralPlace {
  double m = 0.0, v = 0.0, q = 0.0;
  double v_m = 0.0, q_a = 0.0, q_k = 0.0;
};
inline double lateral_v(double m) {
  return m / (m + 2.0);
}
inline LateralPlace lateral_place(double a, double k) {
  const double m = std::min(std::sqrt(3.0 * a + k * k), lateral_largest_m);
  const double bend = 1.0 + k * k / 10.0, h = k * k / bend, sum = 3.0 * a + h;
  return {m,
          lateral_v(m),
          3.0 * a / sum,
          2.0 / ((m + 2.0) * (m + 2.0)),
          3.0 * h / (sum * sum),
          -6.0 * a * k / (bend * bend * sum * sum)};
}

inline Chebyshev<lateral_orders_v> chebyshev_v(double v) {
  return {v, 0.0, lateral_v(lateral_largest_m)};
}
inline Chebyshev<lateral_orders_q> chebyshev_q(double q) {
  return {q, 0.0, 1.0};
}

}  // namespace kappamu::forward
