// Rows of PNG pictures that hold plain codes, inflated by ISA-L: in half the time that libpng and
// zlib take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "io/image/image_limits.h"

namespace kappamu::io {

class PlainPng {
 public:
  /// Nothing where OpenImageIO is to read the file: palettes, alpha or one transparent colour, less
  /// than 8 bits, interlaced rows. `bytes` must hold whole chunks (check_integrity()) and outlive
  /// this.
  static std::optional<PlainPng> open(std::span<const std::byte> bytes);

  const ImageSize& size() const { return size_; }

  /// Codes of one row, [x][channel], rows in order from `y` = 0 on.
  using TakeRow = std::function<void(int y, const std::uint16_t* codes)>;
  /// The first `rows` rows. False where they are damaged; rows before that are handed over.
  bool read(int rows, const TakeRow& take) const;

 private:
  ImageSize size_;
  std::vector<std::span<const std::byte>> data_;  ///< of the IDAT chunks
};

}  // namespace kappamu::io
