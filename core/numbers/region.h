// A rectangle of pixels of a picture.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/image.h"

namespace kappamu {

struct Region {
  int left = 0;    ///< [px] first column
  int top = 0;     ///< [px] first row
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]

  int right() const { return left + width; }
  int bottom() const { return top + height; }
  bool operator==(const Region&) const = default;
};

/// What both hold; of no extent where they do not meet.
inline Region intersection(const Region& a, const Region& b) {
  const int left = std::max(a.left, b.left), top = std::max(a.top, b.top);
  return {left, top, std::max(0, std::min(a.right(), b.right()) - left),
          std::max(0, std::min(a.bottom(), b.bottom()) - top)};
}

/// Grows to the smallest region around all places that were added [px].
class Surrounding {
 public:
  void add(double x, double y) {
    low_x_ = std::min(low_x_, x);
    high_x_ = std::max(high_x_, x);
    low_y_ = std::min(low_y_, y);
    high_y_ = std::max(high_y_, y);
  }
  /// With a margin of `share` of its extent and of `least_px` at least, in a picture of that size;
  /// its left and top edges lie on multiples of `grid` pixels. The whole picture where nothing was
  /// added or nothing of it is inside.
  Region region(double share, double least_px, int grid, int width, int height) const {
    const Region whole{0, 0, width, height};
    if (!(high_x_ >= low_x_)) return whole;
    const double margin = std::max(least_px, share * std::max(high_x_ - low_x_, high_y_ - low_y_));
    const auto below = [&](double at, int most) {
      return static_cast<int>(std::clamp(std::floor((at - margin) / grid) * grid, 0.0, 1.0 * most));
    };
    const auto above = [&](double at, int most) {
      return static_cast<int>(
          std::clamp(std::ceil((at + margin + 1.0) / grid) * grid, 0.0, 1.0 * most));
    };
    const int left = below(low_x_, width), top = below(low_y_, height);
    const Region found{left, top, above(high_x_, width) - left, above(high_y_, height) - top};
    return found.width > 0 && found.height > 0 ? found : whole;
  }

 private:
  double low_x_ = HUGE_VAL, low_y_ = HUGE_VAL, high_x_ = -HUGE_VAL, high_y_ = -HUGE_VAL;
};

/// The region's part of a picture.
template <class T>
Image<T> cropped(Image<T> image, const Region& region) {
  if (region == Region{0, 0, image.width(), image.height()}) return image;
  Image<T> part(region.width, region.height, image.channels());
  for (int y = 0; y < region.height; ++y) {
    std::copy_n(&image(region.left, region.top + y),
                static_cast<std::size_t>(region.width) * image.channels(), &part(0, y));
  }
  return part;
}

}  // namespace kappamu
