// Pictures turned as the EXIF tag Orientation states (EXIF 2.3, 4.6.4).
#pragma once

#include "core/image.h"

namespace kappamu::io {

/// Whether columns become rows: 5 to 8.
inline bool swaps_sides(int orientation) {
  return orientation >= 5;
}

/// The picture upright, where `orientation` (1 to 8) says which sides its first row and first
/// column are: 1 top and left, 3 upside down, 6 to be turned clockwise, 8 counterclockwise; 2, 4,
/// 5, 7 mirrored.
template <class T>
Image<T> turned(Image<T> stored, int orientation) {
  if (orientation == 1) return stored;
  const bool swap = swaps_sides(orientation);
  const bool from_right =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const int width = stored.width(), height = stored.height();
  Image<T> image(swap ? height : width, swap ? width : height, stored.channels());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const int column = swap ? y : x, row = swap ? x : y;
      for (int c = 0; c < image.channels(); ++c) {
        image(x, y, c) = stored(from_right ? width - 1 - column : column,
                                from_bottom ? height - 1 - row : row, c);
      }
    }
  }
  return image;
}

}  // namespace kappamu::io
