#include "calib/sinusoid/relief.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/phase_unwrapping/histogramphaseunwrapping.hpp>
#include <vector>

#include "calib/sinusoid/local_noise.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/shown_text.h"

namespace kappamu::calib {

namespace {

constexpr double full_turn = 2.0 * std::numbers::pi;
constexpr double least_degrees = 1.0;  ///< a fringe moves by 1/57 of the height

/// Phases without jumps of 2π, whose median is within half a period of 0.
Image<float> unwrapped(const Image<float>& wrapped, const Image<std::uint8_t>& mask) {
  cv::phase_unwrapping::HistogramPhaseUnwrapping::Params size;
  size.width = wrapped.width();
  size.height = wrapped.height();
  cv::Mat phase(size.height, size.width, CV_32FC1), valid(size.height, size.width, CV_8UC1), out;
  std::copy(wrapped.values().begin(), wrapped.values().end(), phase.begin<float>());
  std::transform(mask.values().begin(), mask.values().end(), valid.begin<std::uint8_t>(),
                 [](std::uint8_t one) { return one != 0 ? 255 : 0; });
  cv::phase_unwrapping::HistogramPhaseUnwrapping::create(size)->unwrapPhaseMap(phase, out, valid);
  Image<float> result(size.width, size.height, 1);
  std::vector<float> used;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      result(x, y) = out.at<float>(y, x);
      if (mask(x, y) != 0) used.push_back(result(x, y));
    }
  }
  if (used.empty()) return result;
  const auto middle = used.begin() + static_cast<std::ptrdiff_t>(used.size() / 2);
  std::nth_element(used.begin(), middle, used.end());
  const auto periods = static_cast<float>(full_turn * std::round(*middle / full_turn));
  for (float& one : result.values()) one -= periods;
  return result;
}

class Surface {
 public:
  Surface(const Image<std::uint8_t>& mask, const FringeProjector& projector, double pixel_mm)
      : mask_(mask),
        projector_(projector),
        pixel_mm_(pixel_mm),
        along_(projector.distance_mm * std::sin(projector.degrees * std::numbers::pi / 180.0)),
        above_(projector.distance_mm * std::cos(projector.degrees * std::numbers::pi / 180.0)),
        c_(std::cos(projector.direction)),
        s_(std::sin(projector.direction)) {}

  /// The ray through (u, h) meets the plane at u - shift: shift (Pz - h) = h (Pu - u).
  Image<float> heights(const Image<float>& phase) const {
    Image<float> height(phase.width(), phase.height(), 1);
    for_rows(phase.height(), [&](int y) {
      for (int x = 0; x < phase.width(); ++x) {
        if (mask_(x, y) == 0) continue;
        const double shift = -phase(x, y) / (full_turn * projector_.per_mm);
        height(x, y) = static_cast<float>(shift * above_ / (along_ - place(x, y).u + shift));
      }
    });
    return height;
  }

  void light(const Image<float>& smooth, Relief& relief) const {
    for_rows(smooth.height(), [&](int y) {
      for (int x = 0; x < smooth.width(); ++x) {
        if (mask_(x, y) == 0) continue;
        const auto [u, v] = place(x, y);
        const double dx = slope(smooth, x, y, 1, 0), dy = slope(smooth, x, y, 0, 1);
        const double du = c_ * dx + s_ * dy;
        const double h = smooth(x, y), norm = std::sqrt(1.0 + dx * dx + dy * dy);
        const double dv = -s_ * dx + c_ * dy;
        const double to_u = along_ - u, up = above_ - h;
        // Cosine of incidence over squared distance, on the surface and on the plane.
        const double surface = (up - du * to_u + dv * v) / norm / cube(std::hypot(to_u, v, up));
        const double plane = above_ / cube(std::hypot(to_u, v, above_));
        relief.irradiance(x, y) = static_cast<float>(std::max(0.0, surface / plane));
        // Along the surface in the direction of change: d(u - shift)/ds.
        const double shift = (du * to_u - h) / up + h * to_u * du / (up * up);
        relief.frequency(x, y) =
            static_cast<float>(std::abs(1.0 - shift) / std::sqrt(1.0 + du * du));
      }
    });
  }

 private:
  struct Place {
    double u = 0.0, v = 0.0;  ///< [mm], along the fringes' change and across it
  };
  static double cube(double value) { return value * value * value; }
  Place place(int x, int y) const {
    const double dx = (x - 0.5 * (mask_.width() - 1)) * pixel_mm_;
    const double dy = (y - 0.5 * (mask_.height() - 1)) * pixel_mm_;
    return {c_ * dx + s_ * dy, -s_ * dx + c_ * dy};
  }
  /// Of valid neighbours; 0 where there is none.
  double slope(const Image<float>& height, int x, int y, int i, int j) const {
    const auto valid = [&](int a, int b) {
      return a >= 0 && b >= 0 && a < mask_.width() && b < mask_.height() && mask_(a, b) != 0;
    };
    const int back = valid(x - i, y - j) ? 1 : 0, on = valid(x + i, y + j) ? 1 : 0;
    if (back + on == 0) return 0.0;
    return (height(x + on * i, y + on * j) - height(x - back * i, y - back * j)) /
           ((back + on) * pixel_mm_);
  }

  const Image<std::uint8_t>& mask_;
  const FringeProjector& projector_;
  double pixel_mm_;
  double along_, above_;  ///< the projector's place [mm]: towards u, and above the plane
  double c_, s_;
};

}  // namespace

Relief measure_relief(const Image<float>& sample, const Image<float>& plane,
                      const Image<std::uint8_t>& mask, const FringeProjector& projector,
                      double pixel_mm, double sigma_px) {
  check(sample.same_shape(plane) && sample.same_shape(mask), "measure_relief: one size");
  if (!(std::abs(projector.degrees) >= least_degrees && std::abs(projector.degrees) < 80.0)) {
    throw InputError("a projector at " + shown_number(projector.degrees) +
                     " degrees from the camera's axis shows no height; 1 to 80 degrees do");
  }
  Image<float> difference(mask.width(), mask.height(), 1);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask.values()[i] == 0) continue;
    difference.values()[i] = static_cast<float>(
        std::remainder(double{sample.values()[i]} - plane.values()[i], full_turn));
  }
  const Surface surface(mask, projector, pixel_mm);
  const Image<float> one(mask.width(), mask.height(), 1, 1.0F);
  Relief relief{surface.heights(unwrapped(difference, mask)), one, one};
  surface.light(smoothed(relief.height_mm, mask, sigma_px), relief);
  return relief;
}

}  // namespace kappamu::calib
