// Lens numbers as one parameter block for least squares, shared by camera and projector.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "calib/camera.h"
#include "calib/lens.h"

namespace kappamu::calib {

/// fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6.
using LensNumbers = std::array<double, lens_numbers>;

inline LensNumbers numbers_of(const Lens& lens) {
  const auto& d = lens.distortion;
  return {lens.fx, lens.fy, lens.cx, lens.cy, d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

/// `square` pixels use fx for fy, which the model then holds fixed.
inline Lens lens_of(const LensNumbers& n, bool square, int width, int height) {
  return {width,
          height,
          n[0],
          square ? n[0] : n[1],
          n[2],
          n[3],
          {n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11]}};
}

/// Inverse of to_string; throws InputError naming `file`.
LensModel lens_model_from_string(const std::string& name, const std::string& file);

bool has_square_pixels(LensModel model);

/// Indices into LensNumbers that `model` holds fixed.
std::vector<int> fixed_numbers(LensModel model);

/// Projection for automatic differentiation; `numbers` in the order of LensNumbers.
template <class T>
Eigen::Matrix<T, 2, 1> project_numbers(const T* numbers, bool square,
                                       const Eigen::Matrix<T, 3, 1>& point) {
  const std::array<T, 4> focal_centre{numbers[0], square ? numbers[0] : numbers[1], numbers[2],
                                      numbers[3]};
  return project<T>(focal_centre.data(), numbers + 4, point);
}

/// N ln(RSS/N) + p ln N: Bayesian information criterion (Schwarz 1978) of Gaussian residuals with
/// unknown variance, up to a constant. It seldom takes a coefficient that is not there.
inline double bayesian_criterion(double residual_sum_of_squares, std::size_t residuals,
                                 int parameters) {
  const auto n = static_cast<double>(residuals);
  return n * std::log(residual_sum_of_squares / n) + parameters * std::log(n);
}

}  // namespace kappamu::calib
