// Sinusoidal light taken out of pictures: mean M and amplitude A of
//
//     p(x) = M(x) + A(x) cos(2π (u·x) + φ(x)),
//
// from one picture per phase at every pixel, or from a single picture within a window of about a
// period. Pixels are valid where the mask is 1.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"

namespace kappamu::calib {

/// u, cycles per pixel along x and y.
struct Carrier {
  double x = 0.0, y = 0.0;
  double frequency() const;
};

struct Demodulated {
  Image<float> mean, amplitude;                      ///< in the pictures' unit
  Image<float> phase;                                ///< φ of the whole cosine at the pixel [rad]
  Image<float> mean_deviation, amplitude_deviation;  ///< standard deviation of the pixels' noise
  /// Standard deviation of what the window of a single picture does not resolve, at a pixel by
  /// itself: detail of the sample within the window, and detail that looks like the sinusoid. Means
  /// over many pixels do not have it. Empty: nothing is averaged.
  Image<float> mean_detail, amplitude_detail;
  Image<std::uint8_t> mask;      ///< 1: valid
  double shared_pixels = 1.0;    ///< how many neighbours share one value's noise
  double second_harmonic = 0.0;  ///< over the amplitude, mean of the picture
  double stripes = 0.0;          ///< left in mean or amplitude, over the amplitude
};

/// One picture for each of three or more phases [rad], least squares at every pixel: the mean, the
/// first harmonic and from five phases on the second. Stripes are what varies with the demodulated
/// phase more than its neighbours: light that drifts between the phases leaves them at one cycle of
/// mean and amplitude, the projector's third harmonic at three of the mean. Throws InputError where
/// the phases do not determine the amplitude.
Demodulated demodulate_phases(std::span<const Image<float>> pictures,
                              std::span<const double> phases, const Image<std::uint8_t>& mask);

/// The sinusoid in `picture` near `stated`: at most a tenth longer or shorter and 6° turned. Throws
/// InputError where none stands out.
Carrier find_carrier(const Image<float>& picture, const Image<std::uint8_t>& mask,
                     const Carrier& stated);

/// One picture: least squares in a Gaussian window of half a period's standard deviation across the
/// fringes and a seventh along them, with the mean linear and the contrast constant within. `even`,
/// the same sample under even light (empty: none), takes the sample's own pattern out: then the
/// contrast alone is smoothed, and the mean is `even` (its deviation stays 0).
Demodulated demodulate_single(const Image<float>& picture, const Image<float>& even,
                              const Image<std::uint8_t>& mask, const Carrier& carrier);

/// A picture under even light as the mean; amplitude 0.
Demodulated demodulate_even(const Image<float>& picture, const Image<std::uint8_t>& mask);

/// Averages mean and amplitude over valid pixels by a Gaussian of standard deviation `sigma` [px];
/// 0 leaves them.
void smooth(Demodulated& light, double sigma);

}  // namespace kappamu::calib
