#include "core/numbers/elementary.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/numbers/widest.h"

namespace kappamu {

namespace {

/// ln 2 as a sum of which the first has few digits.
constexpr double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
/// A number of this size has integers in its last bits.
constexpr double to_integer = 0x1.8p52;

}  // namespace

/// e^x = 2^k e^r, |r| ≤ (ln 2)/2, e^r by its series.
KAPPAMU_WIDEST void exponentiate(std::span<double> values) {
  for (double& x : values) {
    const double at = std::min(std::max(x, -700.0), 700.0);
    const double shifted = at * 1.4426950408889634074 + to_integer;
    const double k = shifted - to_integer;
    const double r = (at - k * ln2_high) - k * ln2_low;
    double sum = 1.0 / 6227020800.0;
    sum = sum * r + 1.0 / 479001600.0;
    sum = sum * r + 1.0 / 39916800.0;
    sum = sum * r + 1.0 / 3628800.0;
    sum = sum * r + 1.0 / 362880.0;
    sum = sum * r + 1.0 / 40320.0;
    sum = sum * r + 1.0 / 5040.0;
    sum = sum * r + 1.0 / 720.0;
    sum = sum * r + 1.0 / 120.0;
    sum = sum * r + 1.0 / 24.0;
    sum = sum * r + 1.0 / 6.0;
    sum = sum * r + 0.5;
    sum = 1.0 + (r + r * r * sum);
    x = std::bit_cast<double>(std::bit_cast<std::uint64_t>(sum) +
                              (std::bit_cast<std::uint64_t>(shifted) << 52));
  }
}

/// ± ln s, s = |x| + √(x² + 1) = 2^k m with m between √½ and √2, ln m = 2 artanh((m − 1)/(m + 1))
/// by its series.
KAPPAMU_WIDEST void take_arsinh(std::span<double> values) {
  constexpr std::uint64_t root_half = 0x3fe6a09e667f3bcdULL;
  for (double& x : values) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(std::abs(x) + std::sqrt(x * x + 1.0));
    const std::uint64_t power = (bits - root_half) >> 52;
    const auto m = std::bit_cast<double>(bits - (power << 52));
    const double k =
        std::bit_cast<double>(power + std::bit_cast<std::uint64_t>(to_integer)) - to_integer;
    const double t = (m - 1.0) / (m + 1.0), square = t * t;
    double sum = 1.0 / 21.0;
    sum = sum * square + 1.0 / 19.0;
    sum = sum * square + 1.0 / 17.0;
    sum = sum * square + 1.0 / 15.0;
    sum = sum * square + 1.0 / 13.0;
    sum = sum * square + 1.0 / 11.0;
    sum = sum * square + 1.0 / 9.0;
    sum = sum * square + 1.0 / 7.0;
    sum = sum * square + 1.0 / 5.0;
    sum = sum * square + 1.0 / 3.0;
    const double twice = 2.0 * t;
    const double log = k * ln2_high + (twice + (twice * square * sum + k * ln2_low));
    x = std::copysign(log, x) + (x - x);  // not a number of none
  }
}

}  // namespace kappamu
