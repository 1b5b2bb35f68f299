// A camera for capture's tests: shot and read noise, pedestal, response curve, rounding, clipping.
// Written apart from capture's own noise model.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "capture/response/response.h"
#include "core/image.h"

namespace kappamu::capture {

struct SimulatedCamera {
  int bit_depth = 12;
  double black_code = 40.0;  ///< code without light
  double electrons_full_scale = 20000.0;
  double read_noise_electrons = 5.0;
  /// Response: linear signal in [0, 1] to share of the code range, 0 to 0 and 1 to 1, rising.
  std::function<double(double)> curve;

  int top() const { return (1 << bit_depth) - 1; }
  /// Code before rounding and clipping; straight below black with the curve's slope at 0.
  double code_of(double signal) const;
};

/// sRGB's transfer curve, a straight toe below 0.0031.
double srgb_curve(double signal);
/// A film-like curve: gamma 1/2.2 with a toe, and a shoulder.
double shoulder_curve(double signal);
double straight_curve(double signal);

/// Frames of `radiance` (full scales per second) with fixed noise for a seed.
std::vector<ExposedFrame> shoot_stack(const SimulatedCamera& camera, const Image<float>& radiance,
                                      const std::vector<double>& exposures_s, unsigned seed);

/// A smooth scene from `lowest` to `highest` radiance, even in logarithm, with blobs across.
Image<float> smooth_scene(int width, int height, int channels, double lowest, double highest);

/// Seven times from 1/30 s to 8 s.
std::vector<double> seven_exposures();

}  // namespace kappamu::capture
