#include "calib/sinusoid/face_waves.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::calib {

namespace {

// Two patterns are of one sinusoid where their frequencies differ by less than this part of a cycle
// over the face; neighbouring frequencies of a measurement differ by more than one.
constexpr double equal_cycles = 0.25;
// Cycles over the face below which a sinusoid is not told from a gradient.
constexpr double fewest_cycles = 1.5;

Image<float> light_of(const SurfaceMeasurements& m, int pattern) {
  const FaceShape face = m.lit_shape();
  Image<float> light(face.nu, face.nv, 1);
  std::copy_n(m.irradiance.begin() +
                  static_cast<std::ptrdiff_t>(pattern) * static_cast<std::ptrdiff_t>(face.cells()),
              face.cells(), light.values().begin());
  return light;
}

/// The strongest wave of a picture, in a Hann window; nothing where it has none.
std::optional<Carrier> strongest(const Image<float>& light) {
  const int width = light.width(), height = light.height();
  constexpr int finer = 8;  // zeros around make the spectrum's samples as much closer
  cv::Mat padded = cv::Mat::zeros(finer * height, finer * width, CV_64F);
  double mean = 0.0;
  for (const float value : light.values()) mean += value / static_cast<double>(light.size());
  const auto hann = [](int i, int n) {
    const double s = std::sin(std::numbers::pi * (i + 0.5) / n);
    return s * s;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      padded.at<double>(y, x) = hann(x, width) * hann(y, height) * (light(x, y) - mean);
    }
  }
  cv::Mat spectrum;
  cv::dft(padded, spectrum, cv::DFT_COMPLEX_OUTPUT);
  double largest = 0.0;
  Carrier found;
  for (int j = 0; j < spectrum.rows; ++j) {
    const double fy =
        (j < spectrum.rows / 2 ? j : j - spectrum.rows) / static_cast<double>(spectrum.rows);
    for (int i = 0; i <= spectrum.cols / 2; ++i) {  // the other half is this one turned
      const double fx = i / static_cast<double>(spectrum.cols);
      if (std::hypot(fx * width, fy * height) < fewest_cycles) continue;
      const auto& value = spectrum.at<cv::Vec2d>(j, i);
      const double power = value[0] * value[0] + value[1] * value[1];
      if (power <= largest) continue;
      largest = power;
      found = {fx, fy};
    }
  }
  if (!(largest > 0.0)) return {};
  return found;
}

std::optional<Carrier> carrier_of(const Image<float>& light) {
  const std::optional<Carrier> coarse = strongest(light);
  if (!coarse) return {};
  const Image<std::uint8_t> all(light.width(), light.height(), 1, 1);
  try {
    return find_carrier(light, all, *coarse);
  } catch (const InputError&) {  // no sinusoid stands out
    return {};
  }
}

}  // namespace

std::vector<FaceWave> face_waves(const SurfaceMeasurements& m) {
  std::vector<FaceWave> waves;
  const FaceShape face = m.lit_shape();
  for (int pattern = 0; pattern < m.patterns; ++pattern) {
    const std::optional<Carrier> carrier = carrier_of(light_of(m, pattern));
    if (!carrier) continue;
    const auto same = [&](const FaceWave& wave) {
      const auto apart = [&](double sign) {
        return std::hypot((wave.carrier.x - sign * carrier->x) * face.nu,
                          (wave.carrier.y - sign * carrier->y) * face.nv);
      };
      return std::min(apart(1.0), apart(-1.0)) < equal_cycles;
    };
    const auto found = std::find_if(waves.begin(), waves.end(), same);
    if (found == waves.end()) {
      waves.push_back({*carrier, {pattern}});
    } else {
      found->patterns.push_back(pattern);
    }
  }
  for (const FaceWave& wave : waves) {
    if (wave.patterns.size() >= 3) continue;
    throw InputError("the sinusoid of pattern " + std::to_string(wave.patterns.front()) + " has " +
                     std::to_string(wave.patterns.size()) +
                     " phases; three or more over a period are needed");
  }
  std::sort(waves.begin(), waves.end(), [](const FaceWave& a, const FaceWave& b) {
    return a.carrier.frequency() < b.carrier.frequency();
  });
  return waves;
}

FaceAnswer face_answer(const SurfaceMeasurements& m, std::size_t channel, const FaceWave& wave) {
  const FaceShape face = m.seen_shape();
  const Image<float> zero(face.nu, face.nv, 1);
  FaceAnswer answer{zero, zero, zero, zero, Image<std::uint8_t>(face.nu, face.nv, 1), 0.0};
  const auto n = static_cast<double>(wave.patterns.size());
  std::vector<double> stripes;
  for (std::size_t i = 0; i < face.cells(); ++i) {
    double light = 0.0, out = 0.0, variance = 0.0;
    bool used = true;
    const auto at = [&](int pattern) {
      return (channel * static_cast<std::size_t>(m.patterns) + static_cast<std::size_t>(pattern)) *
                 face.cells() +
             i;
    };
    const auto lit = [&](int pattern) {
      return double{m.irradiance[static_cast<std::size_t>(pattern) * face.cells() + i]};
    };
    for (const int pattern : wave.patterns) {
      used = used && (m.mask.empty() || m.mask[at(pattern)] != 0);
      light += lit(pattern) / n;
      out += m.value[at(pattern)] / n;
      variance += m.variance[at(pattern)] / (n * n);
    }
    double squares = 0.0, products = 0.0, spread = 0.0;
    for (const int pattern : wave.patterns) {
      const double change = lit(pattern) - light;
      squares += change * change;
      products += change * (m.value[at(pattern)] - out);
      spread += change * change * m.variance[at(pattern)];
    }
    if (!used || !(light > 0.0) || !(squares > 1e-4 * n * light * light)) continue;
    const double slope = products / squares;
    double rest = 0.0;
    for (const int pattern : wave.patterns) {
      const double left = m.value[at(pattern)] - out - slope * (lit(pattern) - light);
      rest += left * left;
    }
    answer.even.values()[i] = static_cast<float>(out / light);
    answer.even_deviation.values()[i] = static_cast<float>(std::sqrt(variance) / light);
    answer.wave.values()[i] = static_cast<float>(slope);
    answer.wave_deviation.values()[i] = static_cast<float>(std::sqrt(spread) / squares);
    answer.mask.values()[i] = 1;
    if (slope > 0.0) stripes.push_back(std::sqrt(rest / squares) / slope);
  }
  if (!stripes.empty()) answer.stripes = upper_median(std::move(stripes));
  return answer;
}

}  // namespace kappamu::calib
