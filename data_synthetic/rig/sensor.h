// The camera's sensor: radiance becomes electrons, electrons become codes.
//
// A pixel that receives L full scales per second for t seconds collects Poisson(L t N) electrons, N
// the electrons of full scale; read noise is added, the sum s (fraction of N, limited to 1 by the
// well) is encoded as y = b + (1 − b) f(s) and rounded to a code of bit_depth bits, b the black
// level and f the identity (RAW) or a smooth response curve.
#pragma once

#include <array>
#include <cstdint>

#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::synthetic {

struct SensorModel {
  int bit_depth = 12;
  capture::Encoding encoding = capture::Encoding::response;
  double electrons_full_scale = 20000.0;  ///< N at noise_scale 1 [electrons]
  double read_noise_electrons = 5.0;      ///< standard deviation at noise_scale 1 [electrons]
  /// Factor on the standard deviation of both noises; 0 switches noise off.
  double noise_scale = 1.0;
  double black_level = 0.012;  ///< b [fraction of the largest code]
  /// k of the response curve per channel [dimensionless]; see response().
  std::array<double, 3> response_strength{7.0, 8.0, 9.0};
  std::uint64_t seed = 1;

  /// Electrons at full scale and read noise that describe the noise actually present: shot noise
  /// grows by noise_scale when electrons are noise_scale² fewer. The nominal ones without noise.
  double effective_electrons() const;
  double effective_read_noise() const;
};

/// f(s) = 0.85 ln(1 + k s)/ln(1 + k) + 0.15 s² (3 − 2 s): rises smoothly from f(0) = 0 to f(1) = 1,
/// like a film curve; continued below 0 with its slope at 0, constant above 1.
double response(double signal, double strength);

/// y before rounding and without noise [fraction of the largest code]; `signal` in full scales.
double encode(const SensorModel& sensor, double signal, int channel);

/// The codes of one frame. `radiance` is in full scales per second, three channels; `frame` numbers
/// the frames of a session, so that each has its own noise. The same on any number of threads.
Image<std::uint16_t> expose(const SensorModel& sensor, const Image<float>& radiance,
                            double exposure_s, std::uint64_t frame, unsigned threads = 0);

}  // namespace kappamu::synthetic
