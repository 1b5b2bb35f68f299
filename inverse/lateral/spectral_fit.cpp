#include "inverse/lateral/spectral_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"

namespace kappamu::inverse {

namespace {

// Columns of unit length whose smallest singular value is below this cannot be told apart by data
// of four digits.
constexpr double least_distinct = 1e-4;

/// Least squares of the absorbers in `chosen`, the others 0.
Eigen::VectorXd restricted(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right,
                           unsigned chosen) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index j = 0; j < right.size(); ++j) {
    if ((chosen >> j & 1U) != 0) kept.push_back(j);
  }
  Eigen::VectorXd amount = Eigen::VectorXd::Zero(right.size());
  if (kept.empty()) return amount;
  const Eigen::MatrixXd part = normal(kept, kept);
  const Eigen::VectorXd right_part = right(kept);
  const Eigen::VectorXd solved = solve_symmetric(part, right_part);
  amount(kept) = solved;
  return amount;
}

}  // namespace

bool distinct(const Eigen::MatrixXd& spectra) {
  check(spectra.cols() > 0, "distinct: no absorber");
  if (spectra.cols() > spectra.rows()) return false;
  const Eigen::VectorXd length = spectra.colwise().norm();
  if (!(length.minCoeff() > 0.0)) return false;
  const Eigen::MatrixXd unit = spectra * length.cwiseInverse().asDiagonal();
  return symmetric_eigen(gram(unit)).values[0] > least_distinct * least_distinct;
}

AmountFit fit_amounts(const Eigen::MatrixXd& spectra, const Eigen::VectorXd& absorption,
                      const Eigen::VectorXd& deviation) {
  const Eigen::Index n = spectra.cols();
  check(n > 0 && n <= most_absorbers && n <= spectra.rows(), "fit_amounts: too many absorbers");
  // Columns of length one: amounts have units of very different size.
  const Eigen::MatrixXd weighted = deviation.cwiseInverse().asDiagonal() * spectra;
  const Eigen::VectorXd length = weighted.colwise().norm();
  const Eigen::MatrixXd unit = weighted * length.cwiseInverse().asDiagonal();
  const Eigen::VectorXd data = absorption.cwiseQuotient(deviation);
  const Eigen::MatrixXd normal = gram(unit);
  const Eigen::VectorXd right = unit.transpose() * data;

  const unsigned all = (1U << n) - 1U;
  Eigen::VectorXd best = restricted(normal, right, all);
  if (best.minCoeff() < 0.0) {
    // The constrained minimum is the least squares of some of the absorbers: the best of those
    // without a negative amount.
    double least = std::numeric_limits<double>::infinity();
    for (unsigned chosen = 0; chosen < all; ++chosen) {
      const Eigen::VectorXd one = restricted(normal, right, chosen);
      const double residual = (data - unit * one).squaredNorm();
      if (one.minCoeff() >= 0.0 && residual < least) {
        least = residual;
        best = one;
      }
    }
  }
  const auto units = length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = solve_symmetric(normal, Eigen::MatrixXd::Identity(n, n));
  return {units * best, units * inverse * units, (data - unit * best).squaredNorm()};
}

double AmountFit::deviation(Eigen::Index absorber) const {
  return std::sqrt(std::max(0.0, covariance(absorber, absorber)));
}

ScatteringLaw fit_scattering_law(const Eigen::VectorXd& wavelength_nm,
                                 const Eigen::VectorXd& scattering,
                                 const Eigen::VectorXd& deviation) {
  check(wavelength_nm.size() >= 2, "fit_scattering_law: two wavelengths or more");
  const Eigen::VectorXd weight = scattering.cwiseQuotient(deviation);
  Eigen::MatrixX2d lines(wavelength_nm.size(), 2);
  lines.col(0) = weight;
  lines.col(1) = -weight.cwiseProduct((wavelength_nm / 500.0).array().log().matrix());
  const Eigen::Matrix2d covariance = (lines.transpose() * lines).inverse();
  const Eigen::Vector2d law =
      covariance * (lines.transpose() * weight.cwiseProduct(scattering.array().log().matrix()));
  const double at_500nm = std::exp(law[0]);
  return {at_500nm, law[1], at_500nm * std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1))};
}

}  // namespace kappamu::inverse
