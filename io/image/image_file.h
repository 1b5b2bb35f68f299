// Photographs and pictures: camera frames of 8 or 16 bit (PNG, TIFF, JPEG), linear EXR, and the
// pictures of the report, through OpenImageIO or, where a PNG is plain, png_reader.h. One channel
// is grey, three are R, G, B in that order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/image.h"
#include "core/numbers/region.h"
#include "io/image/image_limits.h"

namespace kappamu::io {

/// Code values as stored, 0 for black: 8-bit files give 0 ... 255, 16-bit files 0 ... 65535; no
/// gamma, no rotation by the file's orientation tag, alpha dropped; of a TIFF the one page that is
/// neither preview nor mask. Throws InputError naming the file if it is missing, truncated, damaged
/// or of another kind, or holds other than grey or RGB, or several full pages. `expected` sees the
/// size before anything makes room for it (image_limits.h). With `part`, that region alone, which
/// must lie in the picture: rows below it are not decoded.
Image<std::uint16_t> read_code_image(const std::filesystem::path& file,
                                     const SizeCheck& expected = {},
                                     const std::optional<Region>& part = std::nullopt);

/// The same over the largest code of the file's 8 or 16 bits: 0 ... 1.
Image<float> read_relative_image(const std::filesystem::path& file);

/// Whether the file is a picture of linear floats: its name ends in .exr or .hdr, or it is a TIFF
/// of floats.
bool is_float_image(const std::filesystem::path& file);

/// Primaries and white that an EXR or Radiance picture may state for its R, G, B: those of a
/// camera's channels are its own, colours of a scene are those of sRGB.
enum class Primaries { any, srgb };

/// Linear EXR, Radiance or float TIFF picture: R, G, B, or one channel of grey. Of an EXR's parts
/// and layers the one that holds R, G, B (if there are several, the one without a name of its own,
/// "rgb", "rgba", "beauty" or "combined"), else grey (Y, L, luminance, ...); the display window,
/// black where the data window does not reach. Of a Radiance picture the radiance, exposure and
/// colour correction taken out. Throws InputError naming the file, and the channels where none of
/// them is light; for deep EXR, luminance/chroma EXR, cube maps and other than `primaries`.
Image<float> read_float_image(const std::filesystem::path& file, const SizeCheck& expected = {},
                              Primaries primaries = Primaries::any);

/// PNG or TIFF by the file's extension (.png, .tif, .tiff), one or three channels, lossless.
void write_image(const std::filesystem::path& file, const Image<std::uint8_t>& image);
void write_image(const std::filesystem::path& file, const Image<std::uint16_t>& image);

/// EXR with channels R, G, B, or Y for one channel; 32-bit float.
void write_float_image(const std::filesystem::path& file, const Image<float>& image);

/// Camera codes 0 ... 2^bit_depth - 1, stored unshifted in 8 bits (bit_depth 8) or 16 bits (9 to
/// 16).
void write_code_image(const std::filesystem::path& file, const Image<std::uint16_t>& image,
                      int bit_depth);

/// The bytes of a PNG / JPEG file, for embedding in a report. `quality` 1 to 100.
std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image);
std::vector<std::uint8_t> encode_jpeg(const Image<std::uint8_t>& image, int quality);

}  // namespace kappamu::io
