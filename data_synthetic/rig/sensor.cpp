#include "data_synthetic/rig/sensor.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "data_synthetic/scene/random.h"

namespace kappamu::synthetic {

double SensorModel::effective_electrons() const {
  return noise_scale > 0.0 ? electrons_full_scale / (noise_scale * noise_scale)
                           : electrons_full_scale;
}

double SensorModel::effective_read_noise() const {
  return noise_scale > 0.0 ? read_noise_electrons / noise_scale : read_noise_electrons;
}

double response(double signal, double strength) {
  constexpr double toe = 0.15;
  const double scale = (1.0 - toe) / std::log1p(strength);
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
  const int row_values = radiance.width() * radiance.channels();
  for_rows(
      radiance.height(),
      [&](int y) {
        for (int i = 0; i < row_values; ++i) {
          const std::size_t at = static_cast<std::size_t>(y) * row_values + i;
          double signal = static_cast<double>(radiance.values()[at]) * exposure_s;
          // Light that saturates by ten standard deviations needs no noise.
          const double spread =
              std::sqrt(signal / electrons + read_noise * read_noise / (electrons * electrons));
          if (sensor.noise_scale > 0.0 && signal < 1.0 + 10.0 * spread) {
            const std::uint64_t key = mix(frame_key ^ at);
            const NormalPair normal = normal_pair(key);
            signal = (poisson(signal * electrons, key, normal.first) + read_noise * normal.second) /
                     electrons;
          }
          const double code = std::round(encode(sensor, signal, i % radiance.channels()) * largest);
          codes.values()[at] = static_cast<std::uint16_t>(std::clamp(code, 0.0, largest));
        }
      },
      threads);
  return codes;
}

}  // namespace kappamu::synthetic
