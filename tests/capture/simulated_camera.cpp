#include "tests/capture/simulated_camera.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace kappamu::capture {

double SimulatedCamera::code_of(double signal) const {
  const double range = top() - black_code;
  if (signal < 0.0) {
    constexpr double step = 1e-5;
    return black_code + range * curve(step) / step * signal;
  }
  return black_code + range * curve(std::min(signal, 1.0)) +
         (signal > 1.0 ? (signal - 1.0) * range : 0.0);
}

double srgb_curve(double signal) {
  return signal < 0.0031308 ? 12.92 * signal : 1.055 * std::pow(signal, 1.0 / 2.4) - 0.055;
}

double shoulder_curve(double signal) {
  const auto raw = [](double x) {
    constexpr double toe = 0.004;
    const double gamma = std::pow(x + toe, 1.0 / 2.2) - std::pow(toe, 1.0 / 2.2);
    return gamma / (1.0 + 0.6 * gamma);
  };
  return raw(signal) / raw(1.0);
}

double straight_curve(double signal) {
  return signal;
}

std::vector<ExposedFrame> shoot_stack(const SimulatedCamera& camera, const Image<float>& radiance,
                                      const std::vector<double>& exposures_s, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<ExposedFrame> frames;
  for (const double exposure : exposures_s) {
    ExposedFrame frame{
        Image<std::uint16_t>(radiance.width(), radiance.height(), radiance.channels()), exposure};
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      const double electrons = radiance.values()[i] * exposure * camera.electrons_full_scale;
      // Few photons are counted by Poisson's law, many by its normal limit.
      const double counted = electrons < 50.0 ? static_cast<double>(std::poisson_distribution<int>(
                                                    std::max(electrons, 1e-12))(random))
                                              : electrons + std::sqrt(electrons) * normal(random);
      const double noisy = counted + camera.read_noise_electrons * normal(random);
      const double code = std::round(camera.code_of(noisy / camera.electrons_full_scale));
      frame.pixels.values()[i] =
          static_cast<std::uint16_t>(std::clamp(code, 0.0, static_cast<double>(camera.top())));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

Image<float> smooth_scene(int width, int height, int channels, double lowest, double highest) {
  Image<float> scene(width, height, channels);
  const double decades = std::log(highest / lowest);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double ramp = (x + 0.5) / width;
      const double wave = 0.5 + 0.5 * std::sin(12.0 * y / height + 5.0 * ramp);
      const double share = std::clamp(0.85 * ramp + 0.15 * wave, 0.0, 1.0);
      for (int c = 0; c < channels; ++c) {
        scene(x, y, c) = static_cast<float>(lowest * std::exp(decades * share) * (1.0 - 0.2 * c));
      }
    }
  }
  return scene;
}

std::vector<double> seven_exposures() {
  std::vector<double> times;
  for (int i = 0; i < 7; ++i) times.push_back(1.0 / 30.0 * std::pow(240.0, i / 6.0));
  return times;
}

}  // namespace kappamu::capture
