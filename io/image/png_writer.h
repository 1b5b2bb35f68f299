// PNG files by libpng itself, those of camera frames by strips on all cores. OpenImageIO's writer
// passes libpng no error handler: where an allocation fails libpng prints a line of its own, jumps
// to where a function has already returned, or leaves a file without its end and says nothing.
#pragma once

#include <cstddef>
#include <vector>

namespace kappamu::io {

struct PngPixels {
  const void* values = nullptr;  ///< [y][x][channel], row 0 on top, in the machine's byte order
  int width = 0;
  int height = 0;
  int channels = 1;  ///< 1 or 3
  int bits = 8;      ///< per value, 8 or 16
};

enum class PngEffort {
  small,  ///< zlib's defaults
  fast    ///< for noisy frames: differences along rows, ISA-L's fast search
};

/// Throws std::bad_alloc where memory ends, the one way in which writing into memory fails.
std::vector<unsigned char> write_png(const PngPixels& pixels, PngEffort effort);

}  // namespace kappamu::io
