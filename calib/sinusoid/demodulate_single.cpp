#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calib/sinusoid/demodulate.h"
#include "calib/sinusoid/local_noise.h"
#include "core/parallel.h"

namespace kappamu::calib {

namespace {

// Standard deviation of the window, in periods. Across the fringes, half a period leaves e^(−π²/2)
// = 0.7 % of the fringe outside its own frequency, which the least squares take out; along them
// nothing needs averaging but noise.
constexpr double window_across = 0.5, window_along = 0.15;
// Where the mean is known from even light and subtracted, the nearest other frequency is twice as
// far and half the window separates as well.
constexpr double narrow_across = 0.25;
// A pixel with less than this part of its window valid is not demodulated; a corner has a quarter.
constexpr double least_window = 0.2;

constexpr int unknowns = 5, moments = unknowns * (unknowns + 1) / 2 + unknowns + 1;

/// Sums over the window, by Gaussian filters.
class Window {
 public:
  Window(const Carrier& carrier, double across) {
    const double period = 1.0 / carrier.frequency();
    const auto sigma = [&](double along_axis) {
      const double part = std::abs(along_axis) / carrier.frequency();
      return period * (window_along + (across - window_along) * part);
    };
    sigma_ = {sigma(carrier.x), sigma(carrier.y)};
  }

  void smooth(cv::Mat& plane) const {
    const auto taps = [](double sigma) { return 2 * static_cast<int>(std::ceil(3.5 * sigma)) + 1; };
    cv::GaussianBlur(plane, plane, {taps(sigma_[0]), taps(sigma_[1])}, sigma_[0], sigma_[1],
                     cv::BORDER_CONSTANT);
  }
  /// How many independent pixels the window averages over: (ΣW)²/ΣW².
  double pixels() const { return std::max(1.0, 4.0 * std::numbers::pi * sigma_[0] * sigma_[1]); }

 private:
  std::array<double, 2> sigma_{};  ///< along x and y [px]
};

/// Root mean square, within the window, of the waves that `rest` has across the sinusoid's
/// direction: as many as it has along, where the sample's detail mixes with the sinusoid and cannot
/// be told from it.
Image<float> crossing_waves(const cv::Mat& rest, const Image<std::uint8_t>& mask,
                            const Carrier& carrier, double across) {
  const Carrier turned{-carrier.y, carrier.x};
  const Window window(turned, across);
  std::array<cv::Mat, 3> planes;  // 1, c r, s r
  for (cv::Mat& plane : planes) plane = cv::Mat::zeros(rest.size(), CV_64F);
  for (int y = 0; y < rest.rows; ++y) {
    for (int x = 0; x < rest.cols; ++x) {
      if (mask(x, y) == 0) continue;
      const double phase = 2.0 * std::numbers::pi * (turned.x * x + turned.y * y);
      const double r = rest.at<double>(y, x);
      planes[0].at<double>(y, x) = 1.0;
      planes[1].at<double>(y, x) = std::cos(phase) * r;
      planes[2].at<double>(y, x) = std::sin(phase) * r;
    }
  }
  for (cv::Mat& plane : planes) window.smooth(plane);
  // Of one place the wave is one draw; the mean of the neighbourhood is its expectation.
  cv::Mat power = cv::Mat::zeros(rest.size(), CV_64F), weight = power.clone();
  for (int y = 0; y < rest.rows; ++y) {
    for (int x = 0; x < rest.cols; ++x) {
      const double share = planes[0].at<double>(y, x);
      if (mask(x, y) == 0 || share < least_window) continue;
      const double c = 2.0 * planes[1].at<double>(y, x) / share;
      const double s = 2.0 * planes[2].at<double>(y, x) / share;
      power.at<double>(y, x) = 0.5 * (c * c + s * s);
      weight.at<double>(y, x) = 1.0;
    }
  }
  const double sigma = 1.0 / carrier.frequency();
  cv::GaussianBlur(power, power, {}, sigma, sigma, cv::BORDER_CONSTANT);
  cv::GaussianBlur(weight, weight, {}, sigma, sigma, cv::BORDER_CONSTANT);
  Image<float> result(rest.cols, rest.rows, 1);
  for (int y = 0; y < rest.rows; ++y) {
    for (int x = 0; x < rest.cols; ++x) {
      if (weight.at<double>(y, x) <= 0.0) continue;
      result(x, y) =
          static_cast<float>(std::sqrt(power.at<double>(y, x) / weight.at<double>(y, x)));
    }
  }
  return result;
}

/// Amplitude and phase once more, in half the window, of what exceeds even light times its mean
/// contrast in the wide one.
void refine(Demodulated& result, const Image<float>& picture, const Image<float>& noise,
            const Image<float>& contrast_mean, const Carrier& carrier) {
  cv::Mat left = cv::Mat::zeros(picture.height(), picture.width(), CV_64F);
  const int width = picture.width(), height = picture.height();
  const Window window(carrier, narrow_across);
  const auto wave = [&](int x, int y) {
    const double phase = 2.0 * std::numbers::pi * (carrier.x * x + carrier.y * y);
    return std::array<double, 2>{std::cos(phase), -std::sin(phase)};
  };
  std::array<cv::Mat, 7> planes;  // 1, cc, cs, ss, cq, sq, qq
  for (cv::Mat& plane : planes) plane = cv::Mat::zeros(height, width, CV_64F);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (result.mask(x, y) == 0) continue;
      const auto [c, s] = wave(x, y);
      const double q = picture(x, y) / result.mean(x, y) - contrast_mean(x, y);
      const std::array<double, 7> products{1.0, c * c, c * s, s * s, c * q, s * q, q * q};
      for (std::size_t i = 0; i < planes.size(); ++i) planes[i].at<double>(y, x) = products[i];
    }
  }
  for_rows(static_cast<int>(planes.size()), [&](int i) { window.smooth(planes[i]); });
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (result.mask(x, y) == 0) continue;
      const auto sum = [&](std::size_t i) { return planes[i].at<double>(y, x); };
      Eigen::Matrix2d normal;
      normal << sum(1), sum(2), sum(2), sum(3);
      const Eigen::Vector2d right(sum(4), sum(5));
      const Eigen::Vector2d fit = normal.ldlt().solve(right);
      const double rest = std::max(0.0, sum(6) - fit.dot(right)) / sum(0);
      const auto [c, s] = wave(x, y);
      left.at<double>(y, x) =
          picture(x, y) / result.mean(x, y) - contrast_mean(x, y) - fit[0] * c - fit[1] * s;
      const double grain = noise(x, y) / result.mean(x, y);
      result.amplitude_detail(x, y) = static_cast<float>(
          result.mean(x, y) * std::sqrt(2.0 * std::max(0.0, rest - grain * grain)));
      result.amplitude(x, y) = static_cast<float>(result.mean(x, y) * fit.norm());
      result.amplitude_deviation(x, y) =
          static_cast<float>(result.mean(x, y) * std::sqrt(2.0 * rest / window.pixels()));
      result.phase(x, y) =
          static_cast<float>(std::atan2(-fit[0] * s + fit[1] * c, fit[0] * c + fit[1] * s));
    }
  }
  const Image<float> crossing = crossing_waves(left, result.mask, carrier, narrow_across);
  for (std::size_t i = 0; i < crossing.size(); ++i) {
    float& detail = result.amplitude_detail.values()[i];
    detail = std::hypot(detail, result.mean.values()[i] * crossing.values()[i]);
  }
  result.shared_pixels = window.pixels();
}

/// What is left at twice the phase over the amplitude: the median of squares of three periods, so
/// that a few edges do not count.
double second_harmonic(const Image<float>& picture, const Demodulated& light,
                       const Carrier& carrier) {
  const int side = static_cast<int>(std::lround(3.0 / carrier.frequency()));
  std::vector<double> harmonics;
  for (int y0 = 0; y0 + side <= picture.height(); y0 += side) {
    for (int x0 = 0; x0 + side <= picture.width(); x0 += side) {
      double c = 0.0, s = 0.0, amplitude = 0.0;
      for (int y = y0; y < y0 + side; ++y) {
        for (int x = x0; x < x0 + side; ++x) {
          if (light.mask(x, y) == 0) continue;
          const double left = picture(x, y) - light.mean(x, y);
          c += left * std::cos(2.0 * light.phase(x, y));
          s += left * std::sin(2.0 * light.phase(x, y));
          amplitude += light.amplitude(x, y);
        }
      }
      if (amplitude > 0.0) harmonics.push_back(2.0 * std::hypot(c, s) / amplitude);
    }
  }
  if (harmonics.empty()) return 0.0;
  const auto middle = harmonics.begin() + static_cast<std::ptrdiff_t>(harmonics.size() / 2);
  std::nth_element(harmonics.begin(), middle, harmonics.end());
  return *middle;
}

}  // namespace

Demodulated demodulate_single(const Image<float>& picture, const Image<float>& even,
                              const Image<std::uint8_t>& mask, const Carrier& carrier) {
  const int width = picture.width(), height = picture.height();
  const Window window(carrier, window_across);
  const auto basis = [&](int x, int y) {
    const double phase = 2.0 * std::numbers::pi * (carrier.x * x + carrier.y * y);
    return std::array<double, unknowns>{1.0, std::cos(phase), -std::sin(phase),
                                        static_cast<double>(x) / width - 0.5,
                                        static_cast<double>(y) / height - 0.5};
  };
  const auto value = [&](int x, int y) {
    return even.empty() ? static_cast<double>(picture(x, y)) : picture(x, y) / even(x, y);
  };
  const auto used = [&](int x, int y) {
    return mask(x, y) != 0 && (even.empty() || even(x, y) > 0.0F);
  };
  // Planes: b_i b_j for i ≤ j, b_i p, p².
  std::array<cv::Mat, moments> planes;
  for_rows(moments, [&](int plane) {
    planes[plane] = cv::Mat::zeros(height, width, CV_64F);
    int i = 0, j = plane;
    while (i < unknowns && j >= unknowns - i) j -= unknowns - i++;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!used(x, y)) continue;
        const auto b = basis(x, y);
        const double p = value(x, y);
        planes[plane].at<double>(y, x) = i < unknowns   ? b[i] * b[i + j]
                                         : j < unknowns ? b[j] * p
                                                        : p * p;
      }
    }
    window.smooth(planes[plane]);
  });
  const Image<float> zero(width, height, 1);
  Image<float> contrast_mean(width, height, 1);
  Demodulated result{zero,           zero, zero, zero,
                     zero,           zero, zero, Image<std::uint8_t>(width, height, 1),
                     window.pixels()};
  const Image<float> noise = local_noise(picture, mask);
  cv::Mat left = cv::Mat::zeros(height, width, CV_64F);
  if (!even.empty()) {
    result.mean = even;
  }
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      if (!used(x, y) || planes[0].at<double>(y, x) < least_window) continue;
      Eigen::Matrix<double, unknowns, unknowns> normal;
      Eigen::Matrix<double, unknowns, 1> right;
      int plane = 0;
      for (int i = 0; i < unknowns; ++i) {
        for (int j = i; j < unknowns; ++j) {
          normal(i, j) = normal(j, i) = planes[plane++].at<double>(y, x);
        }
      }
      for (int i = 0; i < unknowns; ++i) right[i] = planes[plane++].at<double>(y, x);
      const Eigen::LDLT<Eigen::Matrix<double, unknowns, unknowns>> factors(normal);
      const Eigen::Matrix<double, unknowns, 1> fit = factors.solve(right);
      const double rest =
          std::max(0.0, planes[plane].at<double>(y, x) - fit.dot(right)) / normal(0, 0);
      const double scale = even.empty() ? 1.0 : even(x, y);
      const double deviation = scale * std::sqrt(rest / window.pixels());
      const auto b = basis(x, y);
      result.amplitude(x, y) = static_cast<float>(scale * std::hypot(fit[1], fit[2]));
      result.amplitude_deviation(x, y) = static_cast<float>(std::numbers::sqrt2 * deviation);
      result.phase(x, y) = static_cast<float>(
          std::atan2(fit[1] * -b[2] + fit[2] * b[1], fit[1] * b[1] - fit[2] * -b[2]));
      contrast_mean(x, y) = static_cast<float>(fit[0] + fit[3] * b[3] + fit[4] * b[4]);
      if (even.empty()) {
        result.mean(x, y) = contrast_mean(x, y);
        result.mean_deviation(x, y) = static_cast<float>(deviation);
        // What the fit leaves at a pixel is the sample's own detail and noise. Detail changes mean
        // and amplitude alike.
        const double grain = noise(x, y);
        const double detail = std::sqrt(std::max(0.0, rest - grain * grain));
        result.mean_detail(x, y) = static_cast<float>(detail);
        result.amplitude_detail(x, y) =
            static_cast<float>(detail * std::hypot(fit[1], fit[2]) / contrast_mean(x, y));
        left.at<double>(y, x) =
            picture(x, y) - fit.dot(Eigen::Map<const Eigen::Matrix<double, unknowns, 1>>(b.data()));
      }
      result.mask(x, y) = 1;
    }
  });
  if (!even.empty()) {
    refine(result, picture, noise, contrast_mean, carrier);
  } else {
    const Image<float> crossing = crossing_waves(left, result.mask, carrier, window_across);
    for (std::size_t i = 0; i < crossing.size(); ++i) {
      float& detail = result.amplitude_detail.values()[i];
      detail = std::hypot(detail, crossing.values()[i]);
    }
  }
  result.second_harmonic = second_harmonic(picture, result, carrier);
  return result;
}

}  // namespace kappamu::calib
