#include "forward/shells/harmonics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"

namespace kappamu::forward::shells {

using Eigen::Vector3d;
using std::numbers::pi;

Eigen::VectorXd harmonics(int bands, const Vector3d& direction) {
  check(bands >= 1 && bands <= most_bands, "harmonics: bands");
  const double x = direction.x(), y = direction.y(), z = direction.z();
  Eigen::VectorXd values(harmonics_in(bands));
  // sin^m θ (cos mψ, sin mψ), and P_l^m / sin^m θ by the recurrence in l; K_l^m from its
  // definition.
  double cosine = 1.0, sine = 0.0, diagonal = 1.0;
  for (int m = 0; m < bands; ++m) {
    double before = 0.0, legendre = diagonal, factorials = 1.0;  // (l−m)!/(l+m)! at l = m
    for (int i = 2; i <= 2 * m; ++i) factorials /= i;
    for (int l = m; l < bands; ++l) {
      const double k = std::sqrt((2.0 * l + 1.0) / (4.0 * pi) * factorials);
      const int centre = l * (l + 1);
      if (m == 0) {
        values[centre] = k * legendre;
      } else {
        values[centre + m] = std::numbers::sqrt2 * k * legendre * cosine;
        values[centre - m] = std::numbers::sqrt2 * k * legendre * sine;
      }
      const double next = ((2.0 * l + 1.0) * z * legendre - (l + m) * before) / (l + 1.0 - m);
      before = legendre;
      legendre = next;
      factorials *= (l + 1.0 - m) / (l + 1.0 + m);
    }
    const double turned = cosine * x - sine * y;
    sine = sine * x + cosine * y;
    cosine = turned;
    diagonal *= 2.0 * m + 1.0;
  }
  return values;
}

Turner::Turner(int bands) : bands_(bands) {
  // A spiral from the pole to the equator: opposite axes would give a band the same lobe twice.
  const int axes = 2 * bands - 1;
  for (int i = 0; i < axes; ++i) {
    const double z = 1.0 - (i + 0.5) / axes;
    const double angle = 2.0 * pi * (std::numbers::phi - 1.0) * i, across = std::sqrt(1.0 - z * z);
    axes_.emplace_back(across * std::cos(angle), across * std::sin(angle), z);
  }
  for (int l = 0; l < bands; ++l) {
    const int size = 2 * l + 1;
    Eigen::MatrixXd lobes(size, size);
    // Spread over the whole spiral: neighbours alone would be almost alike.
    for (int i = 0; i < size; ++i) {
      lobes.col(i) =
          harmonics(bands, axes_[static_cast<std::size_t>(i * (axes - 1) / std::max(1, size - 1))])
              .segment(l * l, size);
    }
    lobes_of_band_.push_back(solve(lobes, Eigen::MatrixXd::Identity(size, size)));
  }
}

Eigen::MatrixXd Turner::turned(const Eigen::MatrixXd& coefficients,
                               const Eigen::Matrix3d& rotation) const {
  check(coefficients.rows() == harmonics_in(bands_), "Turner: bands");
  const int axes = static_cast<int>(axes_.size());
  Eigen::MatrixXd at(coefficients.rows(), axes);
  for (int i = 0; i < axes; ++i) {
    at.col(i) = harmonics(bands_, rotation * axes_[static_cast<std::size_t>(i)]);
  }
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(coefficients.rows(), coefficients.cols());
  for (int l = 0; l < bands_; ++l) {
    const int size = 2 * l + 1;
    const Eigen::MatrixXd lobes =
        lobes_of_band_[static_cast<std::size_t>(l)] * coefficients.middleRows(l * l, size);
    for (int i = 0; i < size; ++i) {
      result.middleRows(l * l, size) +=
          at.col(i * (axes - 1) / std::max(1, size - 1)).segment(l * l, size) * lobes.row(i);
    }
  }
  return result;
}

}  // namespace kappamu::forward::shells
