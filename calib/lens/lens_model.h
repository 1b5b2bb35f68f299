// Lens numbers as one parameter block for least squares, shared by camera and projector.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/lens/lens.h"

namespace kappamu::calib {

/// fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6.
using LensNumbers = std::array<double, lens_numbers>;

inline LensNumbers numbers_of(const Lens& lens) {
  const auto& d = lens.distortion;
  return {lens.fx, lens.fy, lens.cx, lens.cy, d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

/// Square pixels use fx for fy, which the model then holds fixed.
enum class PixelShape { square, rectangular };

inline Lens lens_of(const LensNumbers& n, PixelShape pixels, int width, int height) {
  return {width,
          height,
          n[0],
          pixels == PixelShape::square ? n[0] : n[1],
          n[2],
          n[3],
          {n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11]}};
}

/// Inverse of to_string; throws InputError naming `file`.
LensModel lens_model_from_string(const std::string& name, const std::string& file);

PixelShape pixel_shape(LensModel model);

/// Indices into LensNumbers that `model` holds fixed.
std::vector<int> fixed_numbers(LensModel model);

/// Projection for automatic differentiation; `numbers` in the order of LensNumbers.
template <class T>
Eigen::Matrix<T, 2, 1> project_numbers(const T* numbers, PixelShape pixels,
                                       const Eigen::Matrix<T, 3, 1>& point) {
  const std::array<T, 4> focal_centre{
      numbers[0], pixels == PixelShape::square ? numbers[0] : numbers[1], numbers[2], numbers[3]};
  return project<T>(focal_centre.data(), numbers + 4, point);
}

/// Spread of p1 and p2 over lenses, of elements out of centre (calibrations at hand: 1e-4 to 2e-3).
/// As a Gaussian prior it does nothing where views determine them, and where three or four do not
/// it keeps their ignorance in the covariance: left out they move the principal point by pixels and
/// no standard deviation shows it (docs/calibration.md).
inline constexpr double tangential_spread = 0.002;
/// The same of k1 r² and k2 r⁴ at the corner of the frame, r its distance from the axis at depth 1.
inline constexpr double radial_spread = 0.05;

/// k1, k2, p1, p2 as observations of 0.
struct LensPrior {
  std::array<double, 4> weight{};

  template <class T>
  bool operator()(const T* numbers, T* residual) const {
    for (std::size_t k = 0; k < weight.size(); ++k) residual[k] = weight[k] * numbers[4 + k];
    return true;
  }
};

/// Beside observations whose residuals scatter by `noise`.
inline LensPrior tangential_prior(double noise) {
  return {{0.0, 0.0, noise / tangential_spread, noise / tangential_spread}};
}
inline LensPrior distortion_prior(double noise, double focal_px, int width, int height) {
  LensPrior prior = tangential_prior(noise);
  const double square =
      0.25 * (static_cast<double>(width) * width + static_cast<double>(height) * height) /
      (focal_px * focal_px);
  prior.weight[0] = noise * square / radial_spread;
  prior.weight[1] = noise * square * square / radial_spread;
  return prior;
}

}  // namespace kappamu::calib
