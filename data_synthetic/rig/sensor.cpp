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

// A frame of 24 megapixels has 72 million values: eight at a time, by arithmetic alone.
constexpr int lanes = 8;
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));       // NOLINT
typedef std::int64_t Bits __attribute__((vector_size(lanes * sizeof(double))));  // NOLINT

constexpr double response_toe = 0.15;
double response_scale(double strength) {
  return (1.0 - response_toe) / std::log1p(strength);
}

constexpr double whole = 0x1.8p52;  // added, it leaves the nearest whole number in the last bits

[[gnu::always_inline]] inline void round_lanes(Lanes& x) {
  x = (x + whole) - whole;
}

[[gnu::always_inline]] inline void copy_bits(const Lanes& from, Bits& to) {
  std::memcpy(&to, &from, sizeof to);
}
[[gnu::always_inline]] inline void copy_bits(const Bits& from, Lanes& to) {
  std::memcpy(&to, &from, sizeof to);
}

/// ln x of a normal x > 0, to 1e-13: 2 artanh((m − 1)/(m + 1)) of the mantissa, √½ ≤ m < √2.
[[gnu::always_inline]] inline void take_log(Lanes& x) {
  constexpr auto root_half = std::bit_cast<std::int64_t>(0x1.6a09e667f3bcdp-1);
  constexpr double ln2 = 0.6931471805599453;
  Bits bits;
  Lanes m, powers;
  copy_bits(x, bits);
  const Bits exponent = (bits - root_half) >> 52;
  copy_bits(bits - (exponent << 52), m);
  copy_bits(exponent + std::bit_cast<std::int64_t>(whole), powers);
  const Lanes s = (m - 1.0) / (m + 1.0), square = s * s;
  Lanes sum = Lanes{} + 1.0 / 17.0;
  for (int n = 15; n > 0; n -= 2) sum = 1.0 / n + sum * square;
  x = (powers - whole) * ln2 + 2.0 * s * sum;
}

/// e^x, −700 < x < 700, to 1e-15: a power of two times a series over |x| ≤ ln(2)/2.
[[gnu::always_inline]] inline void take_exp(Lanes& x) {
  constexpr double per_ln2 = 1.4426950408889634;
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;
  const Lanes shifted = x * per_ln2 + whole, power = shifted - whole;
  const Lanes rest = (x - power * ln2_high) - power * ln2_low;
  Lanes sum = Lanes{} + 1.0;
  for (int n = 13; n > 0; --n) sum = 1.0 + sum * rest * (1.0 / n);
  Bits exponent, bits;
  copy_bits(shifted, exponent);
  copy_bits(sum, bits);
  copy_bits(bits + (exponent << 52), x);
}

/// As poisson(), of means up to poisson_is_normal, from uniform numbers.
[[gnu::always_inline]] inline void count_rare(const Lanes& mean, const Lanes& uniforms,
                                              Lanes& count) {
  Lanes remaining = uniforms, probability = -mean;
  take_exp(probability);
  count = Lanes{};
  constexpr std::size_t between_looks = 4;
  for (std::size_t n = 1; n <= most_counted;) {
    Bits going{};
    for (std::size_t k = 0; k < between_looks; ++k, ++n) {
      going = remaining > probability;
      remaining = going ? remaining - probability : Lanes{} - 1.0;
      count += going ? Lanes{} + 1.0 : Lanes{};
      probability *= mean * reciprocals[n];
    }
    std::array<std::int64_t, lanes> any;
    std::memcpy(any.data(), &going, sizeof going);
    std::int64_t all = 0;
    for (const std::int64_t one : any) all |= one;
    if (all == 0) return;
  }
}

/// cos 2πx and sin 2πx, 0 ≤ x ≤ 1, to 1e-15: series over the nearest eighth of a turn.
[[gnu::always_inline]] inline void turn(const Lanes& x, Lanes& cosine, Lanes& sine) {
  const Lanes shifted = 4.0 * x + whole;
  const Lanes angle = (x - 0.25 * (shifted - whole)) * 6.283185307179586, square = angle * angle;
  Lanes s = Lanes{} + 1.0, c = s;
  for (int n = 16; n > 0; n -= 2) {
    c = 1.0 - c * square * (1.0 / (n * (n - 1)));
    s = 1.0 - s * square * (1.0 / (n * (n + 1)));
  }
  s *= angle;
  Bits quarter, bits;
  copy_bits(shifted, quarter);
  const Bits odd = (quarter & 1) != 0;
  copy_bits(odd ? s : c, bits);
  copy_bits(bits ^ (((quarter + 1) & 2) << 62), cosine);
  copy_bits(odd ? c : s, bits);
  copy_bits(bits ^ ((quarter & 2) << 62), sine);
}

/// What all values of a frame share.
struct Exposure {
  double exposure_s = 0.0, electrons = 1.0, read_noise = 0.0, black_level = 0.0, largest = 1.0;
  bool noisy = true, linear = true;
  std::uint64_t frame_key = 0;
  std::size_t channels = 3;
  std::array<double, lanes + 2> strength{}, scale{};  ///< of the response, by channel, repeated
};

/// Values [at, at + count) of a picture, at most eight; `channel` is that of the first. As
/// normal_pair(), poisson() and encode().
[[gnu::always_inline]] inline void expose_lanes(const Exposure& e, const float* radiance,
                                                std::uint64_t at, std::size_t channel,
                                                std::size_t count, std::uint16_t* codes) {
  std::array<double, lanes> values{};
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(radiance[i]);
  Lanes signal;
  std::memcpy(&signal, values.data(), sizeof signal);
  signal *= e.exposure_s;
  if (e.noisy) {
    std::array<std::uint64_t, lanes> keys;
    std::array<double, lanes> first, turns, means;
    for (std::size_t i = 0; i < lanes; ++i) {
      keys[i] = mix(e.frame_key ^ (at + i));
      first[i] = uniform(keys[i]);
      turns[i] = uniform(keys[i] ^ second_of_pair);
    }
    Lanes radius, part, root, cosine, sine;
    std::memcpy(&radius, first.data(), sizeof radius);
    std::memcpy(&part, turns.data(), sizeof part);
    take_log(radius);
    radius *= -2.0;
    const Lanes mean = signal * e.electrons;
    std::memcpy(first.data(), &radius, sizeof radius);
    std::memcpy(means.data(), &mean, sizeof mean);
    for (std::size_t i = 0; i < lanes; ++i) {
      first[i] = std::sqrt(first[i]);
      turns[i] = std::sqrt(means[i]);
    }
    std::memcpy(&radius, first.data(), sizeof radius);
    std::memcpy(&root, turns.data(), sizeof root);
    turn(part, cosine, sine);
    const Lanes normal = radius * cosine;
    Lanes counted = mean + root * normal;
    round_lanes(counted);
    if (*std::min_element(means.begin(), means.end()) <= poisson_is_normal) {
      for (std::size_t i = 0; i < lanes; ++i) first[i] = uniform(keys[i] ^ of_poisson);
      const Bits rare = mean <= poisson_is_normal;
      Lanes drawn, few;
      std::memcpy(&drawn, first.data(), sizeof drawn);
      count_rare(rare ? mean : Lanes{}, drawn, few);
      counted = rare ? few : counted;
    }
    const double per_electron = 1.0 / e.electrons;
    const Lanes noisy = (counted + e.read_noise * (radius * sine)) * per_electron;
    // Light that saturates by ten standard deviations needs no noise.
    const Lanes beyond = signal - 1.0;
    const double read = e.read_noise * per_electron;
    const Lanes variance = signal * per_electron + read * read;
    signal = ((beyond < 0.0) | (beyond * beyond < 100.0 * variance)) ? noisy : signal;
  }
  Lanes encoded = signal;
  if (!e.linear) {
    Lanes strength, scale;
    std::memcpy(&strength, &e.strength[channel], sizeof strength);
    std::memcpy(&scale, &e.scale[channel], sizeof scale);
    const Lanes lit = signal > 0.0 ? signal : Lanes{};
    Lanes log = 1.0 + strength * lit;
    take_log(log);
    encoded = scale * log + response_toe * lit * lit * (3.0 - 2.0 * lit);
    encoded = signal > 0.0 ? encoded : scale * strength * signal;
  }
  encoded = signal < 1.0 ? encoded : Lanes{} + 1.0;
  Lanes code = (e.black_level + (1.0 - e.black_level) * encoded) * e.largest;
  round_lanes(code);
  code = code > 0.0 ? code : Lanes{};
  code = code < e.largest ? code : Lanes{} + e.largest;
  std::memcpy(values.data(), &code, sizeof code);
  for (std::size_t i = 0; i < count; ++i) codes[i] = static_cast<std::uint16_t>(values[i]);
}

KAPPAMU_WIDEST void expose_row(const Exposure& e, const float* radiance, std::uint64_t at,
                               std::size_t count, std::uint16_t* codes) {
  std::size_t i = 0, channel = 0;
  for (; i + lanes <= count; i += lanes) {
    expose_lanes(e, radiance + i, at + i, channel, lanes, codes + i);
    channel = (channel + lanes) % e.channels;
  }
  expose_lanes(e, radiance + i, at + i, channel, count - i, codes + i);
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
  for_rows(
      radiance.height(),
      [&](int y) {
        const std::size_t at = static_cast<std::size_t>(y) * row;
        expose_row(e, &radiance.values()[at], at, row, &codes.values()[at]);
      },
      threads);
  return codes;
}

}  // namespace kappamu::synthetic
