// Camera RAW files (DNG, CR2 and whatever else LibRaw reads): the sensor's own codes, unprocessed.
// By LibRaw itself, since OpenImageIO 2.4 hands on neither black nor white level and dereferences a
// null pointer where LibRaw cannot unpack a truncated file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/image.h"
#include "io/image/image_limits.h"
#include "io/image/photo_settings.h"

namespace kappamu::io {

/// Whether the name ends like a camera RAW file (.dng, .cr2, .nef, .arw, ...).
bool is_raw_file(const std::filesystem::path& file);

/// Colours of a Bayer sensor's sites: index 2 * (y % 2) + x % 2, value 0 = R, 1 = G, 2 = B.
using BayerLayout = std::array<int, 4>;

struct RawImage {
  /// Codes of the visible area, no black subtracted, no white balance. Of a sensor: as it gave
  /// them, one channel, both extents even. Of a linear DNG: R, G, B, by the converter that wrote
  /// it.
  Image<std::uint16_t> codes;
  std::optional<BayerLayout> layout;  ///< of a mosaic; nothing: grey, or three channels
  std::array<double, 3> black{};      ///< R, G, B or grey: black level by the file [codes]
  int white = 0;                      ///< code at which the sensor saturates, by the file

  /// Of the picture: R, G, B also of a mosaic; or grey.
  int channels() const { return layout ? 3 : codes.channels(); }
};

/// Throws InputError naming the file if it is missing, truncated, unknown to LibRaw, holds floating
/// point numbers, or is neither of a Bayer nor of a grey sensor nor a linear DNG of three colours
/// (X-Trans, other formats' reduced RAW). `expected` sees the codes' size before they are unpacked.
RawImage read_raw(const std::filesystem::path& file, const SizeCheck& expected = {});

/// How the codes of a RAW file without a header lie, row by row, each row from left to right.
struct RawLayout {
  int bits = 16;  ///< a stored code has: 8, or 16 in two bytes
  bool big_endian = false;
  int offset = 0;                       ///< of the first code [bytes]
  std::optional<BayerLayout> mosaic{};  ///< nothing: a grey camera
};

/// The codes of such a file, one channel. Throws InputError naming the file where its size is not
/// that of the layout.
Image<std::uint16_t> read_headerless_raw(const std::filesystem::path& file, const RawLayout& layout,
                                         int width, int height);

/// Nothing from files that LibRaw does not take. Throws InputError only if `file` cannot be opened.
PhotoSettings read_raw_settings(const std::filesystem::path& file);

}  // namespace kappamu::io
