#include "data_synthetic/rig/sensor.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/numbers/widest.h"
#include "core/parallel.h"
#include "data_synthetic/scene/random.h"

namespace kappamu::synthetic {

namespace {

constexpr double response_toe = 0.15;
double response_scale(double strength) {
  return (1.0 - response_toe) / std::log1p(strength);
}

constexpr double whole = 0x1.8p52;  // added, it leaves the nearest whole number in the last bits

constexpr std::size_t most_lanes = 8;

/// What all values of a frame share.
struct Exposure {
  double exposure_s = 0.0, electrons = 1.0, read_noise = 0.0, black_level = 0.0, largest = 1.0;
  bool noisy = true, linear = true;
  std::uint64_t frame_key = 0;
  std::size_t channels = 3;
  std::array<double, most_lanes + 2> strength{},
      scale{};  ///< of the response, by channel, repeated
};

using ExposeRow = void (*)(const Exposure&, const float*, std::uint64_t, std::size_t,
                           std::uint16_t*);

// A frame of 24 megapixels has 72 million values. Eight lanes on registers of four take 2.5 times
// as long as four lanes.
namespace any_registers {
constexpr int lanes = 4;
#include "data_synthetic/rig/sensor_lanes.inc"
}  // namespace any_registers
#if KAPPAMU_WIDTHS
#pragma GCC push_options
#pragma GCC optimize("no-math-errno")
#pragma GCC target("avx2")
namespace avx2_registers {
constexpr int lanes = 4;
#include "data_synthetic/rig/sensor_lanes.inc"
}  // namespace avx2_registers
#pragma GCC target("avx512f,avx512dq")
namespace avx512_registers {
constexpr int lanes = 8;
#include "data_synthetic/rig/sensor_lanes.inc"
}  // namespace avx512_registers
#pragma GCC pop_options
#endif

ExposeRow expose_row() {
#if KAPPAMU_WIDTHS
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return avx512_registers::expose_row;
  if (__builtin_cpu_supports("avx2")) return avx2_registers::expose_row;
#endif
  return any_registers::expose_row;
}

}  // namespace

double SensorModel::effective_electrons() const {
  return noise_scale > 0.0 ? electrons_full_scale / (noise_scale * noise_scale)
                           : electrons_full_scale;
}

double SensorModel::effective_read_noise() const {
  return noise_scale > 0.0 ? read_noise_electrons / noise_scale : read_noise_electrons;
}

double response(double signal, double strength) {
  constexpr double toe = response_toe;
  const double scale = response_scale(strength);
  if (signal <= 0.0) return scale * strength * signal;
  if (signal >= 1.0) return 1.0;
  return scale * std::log1p(strength * signal) + toe * signal * signal * (3.0 - 2.0 * signal);
}

double encode(const SensorModel& sensor, double signal, int channel) {
  const double encoded = sensor.encoding == capture::Encoding::linear
                             ? std::min(signal, 1.0)
                             : response(signal, sensor.response_strength[channel]);
  return sensor.black_level + (1.0 - sensor.black_level) * encoded;
}

Image<std::uint16_t> expose(const SensorModel& sensor, const Image<float>& radiance,
                            double exposure_s, std::uint64_t frame, unsigned threads) {
  Image<std::uint16_t> codes(radiance.width(), radiance.height(), radiance.channels());
  const double largest = std::ldexp(1.0, sensor.bit_depth) - 1.0;
  const double electrons = sensor.effective_electrons();
  const double read_noise = sensor.effective_read_noise();
  const std::uint64_t frame_key = key_of({sensor.seed, 0xF4A3E, frame});
  const auto channels = static_cast<std::size_t>(radiance.channels());
  check(channels <= sensor.response_strength.size(), "the sensor has at most three channels");
  Exposure e{exposure_s,
             electrons,
             read_noise,
             sensor.black_level,
             largest,
             sensor.noise_scale > 0.0,
             sensor.encoding == capture::Encoding::linear,
             frame_key,
             channels};
  for (std::size_t i = 0; i < e.strength.size(); ++i) {
    e.strength[i] = sensor.response_strength[i % channels];
    e.scale[i] = response_scale(e.strength[i]);
  }
  const std::size_t row = static_cast<std::size_t>(radiance.width()) * channels;
  const ExposeRow expose_values = expose_row();
  for_rows(
      radiance.height(),
      [&](int y) {
        const std::size_t at = static_cast<std::size_t>(y) * row;
        expose_values(e, &radiance.values()[at], at, row, &codes.values()[at]);
      },
      threads);
  return codes;
}

}  // namespace kappamu::synthetic
