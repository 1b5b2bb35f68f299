// Values of PNG, TIFF, JPEG and BMP pictures as they are stored: one page, grey or R, G, B, alpha
// dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/numbers/region.h"
#include "io/image/image_limits.h"

namespace kappamu::io {

struct CodePicture {
  Image<std::uint16_t> codes;
  int bits = 8;  ///< of each code in the file, 8 or 16
};

/// Of `part` alone, where one is wanted. Throws as read_code_image() (image_file.h).
CodePicture read_codes(const std::filesystem::path& file, const SizeCheck& expected,
                       const std::optional<Region>& part = {});

/// One row of codes, [x][channel], rows in order from `y` = 0 of the part on.
using TakeCodeRow = std::function<void(int y, const std::uint16_t* codes)>;

/// As read_codes(), row by row, without a picture of them. Rows before a damage are handed over.
void read_code_rows(const std::filesystem::path& file, const SizeCheck& expected,
                    const std::optional<Region>& part, const TakeCodeRow& take);

/// Whether a TIFF's first page holds floats (SampleFormat; TIFF 6.0, section 19).
bool is_float_tiff(std::span<const std::byte> bytes);

/// The floats of such a TIFF, of 16 or 32 bits. Throws as read_float_image() (image_file.h).
Image<float> read_tiff_floats(const std::filesystem::path& file, std::vector<std::byte>& bytes,
                              const SizeCheck& expected);

}  // namespace kappamu::io
