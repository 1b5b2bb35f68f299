#include "inverse/lateral/lateral_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

constexpr int most_steps = 40;
constexpr double settled = 1e-6;  ///< step of ln μa and ln σs'
// Pixels whose two frequencies are nearly redundant are left out: noise would dominate.
constexpr double least_determinant = 1e-12;

}  // namespace

LateralFit fit_lateral(const forward::LateralReflectance& model, const PerFrequency& frequency,
                       const PerFrequency& reflectance, const PerFrequency& deviation,
                       const LateralCoefficients& start, const FarSides& far) {
  const Eigen::Index n = frequency.size();
  check(n >= 2 && n <= most_frequencies, "fit_lateral: two frequencies or more");
  LateralFit fit;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(reflectance[i] > 0.0) || !(deviation[i] > 0.0)) {
      fit.verdict = LateralVerdict::no_light;
      return fit;
    }
  }
  Eigen::Vector2d x(std::log(start.mua), std::log(start.musp));
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, most_frequencies, 2> jacobian(n, 2);
  PerFrequency residual(n);
  for (int step = 0; step < most_steps; ++step) {
    const double mua = std::exp(x[0]), musp = std::exp(x[1]);
    for (Eigen::Index i = 0; i < n; ++i) {
      const forward::LateralValue value =
          seen(model, far[static_cast<std::size_t>(i)], frequency[i], mua, musp);
      const double weight = 1.0 / deviation[i];
      residual[i] = weight * std::log(reflectance[i] / value.reflectance);
      jacobian(i, 0) = weight * mua * value.d_mua / value.reflectance;
      jacobian(i, 1) = weight * musp * value.d_musp / value.reflectance;
    }
    const Eigen::Matrix2d normal = jacobian.transpose() * jacobian;
    if (!(normal.determinant() > least_determinant * normal(0, 0) * normal(1, 1))) return fit;
    const Eigen::Matrix2d inverse = normal.inverse();
    Eigen::Vector2d move = inverse * (jacobian.transpose() * residual);
    const bool done = move.cwiseAbs().maxCoeff() < settled;
    if (!done) {
      x[0] += std::clamp(move[0], -1.0, 1.0);
      x[1] += std::clamp(move[1], -0.5, 0.5);
      // μa from 1e-6 to 1e3 per mm: beyond, no medium has this reflectance.
      if (std::abs(x[0] + 3.45) > 10.4 || std::abs(x[1]) > 8.0) return fit;
      continue;
    }
    fit.coefficients = {mua, musp};
    fit.gain = inverse * jacobian.transpose();
    for (Eigen::Index i = 0; i < n; ++i) fit.gain.col(i) /= deviation[i];
    fit.chi_square = n > 2 ? residual.squaredNorm() : 0.0;
    fit.verdict = LateralVerdict::good;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (!forward::LateralReflectance::covers(frequency[i], mua, musp)) {
        fit.verdict = LateralVerdict::outside_table;
      }
    }
    return fit;
  }
  return fit;
}

}  // namespace kappamu::inverse
