// The papers' own recoveries of the camera's response, as named baselines for `--response` and the
// charts; capture/response/response.h is ours. Both see code 0 as no light and know nothing of
// noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "capture/response/exposed_frame.h"

namespace kappamu::capture {

/// Codes of single pixels under the exposures of their stack, one channel.
struct PixelSamples {
  std::vector<double> exposure_s;                 ///< [frame]
  std::vector<std::vector<std::uint16_t>> codes;  ///< [pixel][frame]
};

/// Every k-th pixel of the stack, `most` at the most, spread evenly over the frame.
PixelSamples sample_pixels(std::span<const ExposedFrame> stack, int channel, std::size_t most);

/// Debevec & Malik 1997, eq. (3): exp g [code], g(128) = 0 for eight bits, weights w the hat of eq.
/// (4) plus 1, smoothness `lambda` (in the rows of the equations, as in the paper's program). With
/// more than eight bits g has 256 knots, evenly spaced over the codes, and is linear between them,
/// as the unknowns would not fit otherwise. Throws InputError beginning with `name` if no pixel is
/// seen twice.
std::vector<double> recover_debevec_malik(const std::vector<PixelSamples>& stacks, int bit_depth,
                                          double lambda, const std::string& name);

/// Robertson, Borman & Stevenson 2003: Gauss-Seidel between response and radiance, at most
/// `rounds` times; 1 at the middle code. Codes that no sample has are interpolated.
std::vector<double> recover_robertson(const std::vector<PixelSamples>& stacks, int bit_depth,
                                      int rounds, const std::string& name);

/// Weight of a code at `share` of the range in Robertson's method: a bell, 0 at both ends.
inline float robertson_bell(float share) {
  const float z = 4.0F * share - 2.0F;
  constexpr float at_the_ends = 0.018315639F;  // exp(-4)
  return (std::exp(-z * z) - at_the_ends) / (1.0F - at_the_ends);
}

/// A baseline's curve as Response asks for it: rising, 0 at the black level, 1 at the largest code.
std::vector<double> normalised_response(std::vector<double> curve, double black_level);

/// Pools adjacent violators, then keeps the smallest slope that leaves the table invertible.
/// Returns the number of codes changed.
int make_rising(std::vector<double>& linear);

}  // namespace kappamu::capture
