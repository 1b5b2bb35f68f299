#include "calib/sinusoid/demodulate.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "calib/sinusoid/local_noise.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "core/parallel.h"

namespace kappamu::calib {

namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
// A sinusoid with less of a picture's variance than this is not taken for one; noise alone reaches
// 0.01 in pictures of 100 x 100 pixels.
constexpr double least_part = 0.03;

Demodulated empty_result(int width, int height) {
  const Image<float> zero(width, height, 1);
  return {zero, zero, zero, zero, zero, {}, {}, Image<std::uint8_t>(width, height, 1)};
}

/// Periods across the picture by which a neighbouring wave differs: beyond the main lobe of a Hann
/// window, 2.
constexpr double apart = 3.0;

/// Amplitude in `map` of the wave of `cycles` times the phase, with `more` periods across the
/// picture's width and height; a Hann window keeps slow structure out.
double wave_in(const Image<float>& map, const Demodulated& at, int cycles,
               const std::array<double, 2>& more) {
  const auto hann = [](int i, int n) {
    const double s = std::sin(std::numbers::pi * (i + 0.5) / n);
    return s * s;
  };
  double mean = 0.0, weights = 0.0, c = 0.0, s = 0.0;
  const auto over_valid = [&](const auto& add) {
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x) {
        if (at.mask(x, y) != 0) add(x, y, hann(x, map.width()) * hann(y, map.height()));
      }
    }
  };
  over_valid([&](int x, int y, double weight) {
    mean += weight * map(x, y);
    weights += weight;
  });
  if (weights == 0.0) return 0.0;
  mean /= weights;
  over_valid([&](int x, int y, double weight) {
    const double phase =
        cycles * at.phase(x, y) + two_pi * (more[0] * x / map.width() + more[1] * y / map.height());
    c += weight * (map(x, y) - mean) * std::cos(phase);
    s += weight * (map(x, y) - mean) * std::sin(phase);
  });
  return 2.0 * std::hypot(c, s) / weights;
}

/// The same of a wave that stands out: an edge of the sample is in the neighbouring waves too.
double standing_wave(const Image<float>& map, const Demodulated& at, int cycles, double scale) {
  double neighbour = 0.0;
  for (const std::array<double, 2>& more : {std::array{apart, 0.0}, std::array{-apart, 0.0},
                                            std::array{0.0, apart}, std::array{0.0, -apart}}) {
    neighbour = std::max(neighbour, wave_in(map, at, cycles, more));
  }
  return std::max(0.0, wave_in(map, at, cycles, {0.0, 0.0}) - neighbour) / scale;
}

double mean_of(const Image<float>& map, const Image<std::uint8_t>& mask) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (mask.values()[i] == 0) continue;
    sum += map.values()[i];
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

/// [phase][1, cos, -sin, cos 2, ...]: what mean and harmonics make of a picture.
Eigen::MatrixXd waves_at(std::span<const double> phases, Eigen::Index harmonics) {
  const auto n = static_cast<Eigen::Index>(phases.size());
  Eigen::MatrixXd basis(n, 1 + 2 * harmonics);
  for (Eigen::Index row = 0; row < n; ++row) {
    basis(row, 0) = 1.0;
    for (Eigen::Index h = 1; h <= harmonics; ++h) {
      basis(row, 2 * h - 1) = std::cos(static_cast<double>(h) * phases[row]);
      basis(row, 2 * h) = -std::sin(static_cast<double>(h) * phases[row]);
    }
  }
  return basis;
}

bool determines_all(const Eigen::MatrixXd& basis) {
  if (basis.rows() < basis.cols()) return false;
  const Eigen::VectorXd values = symmetric_eigen(gram(basis)).values;
  return values[0] >= 1e-3 * values[basis.cols() - 1];
}

}  // namespace

double Carrier::frequency() const {
  return std::hypot(x, y);
}

Demodulated demodulate_phases(std::span<const Image<float>> pictures,
                              std::span<const double> phases, const Image<std::uint8_t>& mask) {
  check(pictures.size() == phases.size() && !pictures.empty(), "demodulate_phases: one per phase");
  const auto n = static_cast<Eigen::Index>(phases.size());
  // Seven phases 90 degrees apart tell no more harmonics than four.
  Eigen::Index harmonics = 2;
  Eigen::MatrixXd basis = waves_at(phases, harmonics);
  if (!determines_all(basis)) basis = waves_at(phases, harmonics = 1);
  if (!determines_all(basis)) {
    throw InputError(
        "the phases do not determine mean and amplitude; take three or more spread evenly over "
        "360 degrees, or one");
  }
  const Eigen::MatrixXd solve = solve_symmetric(gram(basis), basis.transpose());
  Demodulated result = empty_result(mask.width(), mask.height());
  result.mask = mask;
  double second = 0.0, first = 0.0;
  Eigen::VectorXd p(n);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask.values()[i] == 0) continue;
    for (Eigen::Index row = 0; row < n; ++row) p[row] = pictures[row].values()[i];
    const Eigen::VectorXd fit = solve * p;
    const double amplitude = std::hypot(fit[1], fit[2]);
    result.mean.values()[i] = static_cast<float>(fit[0]);
    result.amplitude.values()[i] = static_cast<float>(amplitude);
    result.phase.values()[i] = static_cast<float>(std::atan2(fit[2], fit[1]));
    first += amplitude;
    if (harmonics == 2) second += std::hypot(fit[3], fit[4]);
  }
  result.mean_deviation = local_noise(result.mean, mask);
  result.amplitude_deviation = local_noise(result.amplitude, mask);
  if (harmonics == 2 && first > 0.0) result.second_harmonic = second / first;
  const double scale = mean_of(result.amplitude, mask);
  if (scale > 0.0) {
    result.stripes = std::max({standing_wave(result.mean, result, 1, scale),
                               standing_wave(result.mean, result, 3, scale),
                               standing_wave(result.amplitude, result, 1, scale)});
    // Three phases cannot tell the second harmonic from the first: it beats in the amplitude.
    if (n == 3) result.second_harmonic = standing_wave(result.amplitude, result, 3, scale);
  }
  return result;
}

Carrier find_carrier(const Image<float>& picture, const Image<std::uint8_t>& mask,
                     const Carrier& stated) {
  const int width = picture.width(), height = picture.height();
  const double mean = mean_of(picture, mask);
  std::vector<double> windowed(picture.size(), 0.0);
  double weights = 0.0, squares = 0.0;  // of the window; of what varies in it
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (mask(x, y) == 0) continue;
      const double hann = std::sin(std::numbers::pi * (x + 0.5) / width) *
                          std::sin(std::numbers::pi * (y + 0.5) / height);
      const double weight = hann * hann, varies = picture(x, y) - mean;
      windowed[static_cast<std::size_t>(y) * width + x] = weight * varies;
      weights += weight;
      squares += weight * varies * varies;
    }
  }
  // The spectrum on (2n+1)² carriers about `centre`, first along x, then along y.
  constexpr int n = 12;
  const auto search = [&](const Carrier& centre, double step, double& largest) {
    std::vector<double> power((2 * n + 1) * (2 * n + 1));
    for_rows(2 * n + 1, [&](int i) {
      const double u = two_pi * (centre.x + step * (i - n));
      std::vector<std::array<double, 2>> lines(height);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const double w = windowed[static_cast<std::size_t>(y) * width + x];
          lines[y][0] += w * std::cos(u * x);
          lines[y][1] -= w * std::sin(u * x);
        }
      }
      for (int j = 0; j <= 2 * n; ++j) {
        const double v = two_pi * (centre.y + step * (j - n));
        double re = 0.0, im = 0.0;
        for (int y = 0; y < height; ++y) {
          const double c = std::cos(v * y), s = std::sin(v * y);
          re += lines[y][0] * c + lines[y][1] * s;
          im += lines[y][1] * c - lines[y][0] * s;
        }
        power[i * (2 * n + 1) + j] = re * re + im * im;
      }
    });
    const auto best = std::max_element(power.begin(), power.end()) - power.begin();
    largest = power[static_cast<std::size_t>(best)];
    return Carrier{centre.x + step * (static_cast<double>(best / (2 * n + 1)) - n),
                   centre.y + step * (static_cast<double>(best % (2 * n + 1)) - n)};
  };
  const double span = 0.1 * stated.frequency();
  double power = 0.0, ignored = 0.0;
  Carrier found = search(stated, span / n, power);
  const double off = std::max(std::abs(found.x - stated.x), std::abs(found.y - stated.y));
  // The sinusoid's part of what varies: (A²/2)/variance with A = 2 √power/weights.
  const double part = squares > 0.0 ? 2.0 * power / (weights * squares) : 0.0;
  if (part < least_part || off > 0.95 * span) {
    throw InputError("no sinusoid of " + std::to_string(1.0 / stated.frequency()) +
                     " pixels a period stands out; check pixel_mm, per_mm and direction_degrees");
  }
  for (double step = span / n / n; step > 1e-7; step /= n / 2.0)
    found = search(found, step, ignored);
  return found;
}

Demodulated demodulate_even(const Image<float>& picture, const Image<std::uint8_t>& mask) {
  Demodulated result = empty_result(mask.width(), mask.height());
  result.mask = mask;
  result.mean = picture;
  result.mean_deviation = local_noise(picture, mask);
  return result;
}

void smooth(Demodulated& light, double sigma) {
  if (sigma <= 0.0) return;
  // A Gaussian averages over 4πσ² pixels.
  const double pixels = std::max(1.0, 4.0 * std::numbers::pi * sigma * sigma);
  const auto one = [&](Image<float>& value, Image<float>& deviation) {
    value = smoothed(value, light.mask, sigma);
    for (float& d : deviation.values()) d /= static_cast<float>(std::sqrt(pixels));
  };
  one(light.mean, light.mean_deviation);
  one(light.amplitude, light.amplitude_deviation);
  light.shared_pixels = pixels;
}

}  // namespace kappamu::calib
