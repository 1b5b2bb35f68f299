// What OpenImageIO does not find in the bytes of a photograph, or finds only after it has filled
// the memory.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "io/image/image_limits.h"

namespace kappamu::io {

enum class ImageKind { png, tiff, jpeg, bmp, exr, radiance, unknown };

/// Unsigned number of `size` bytes at `at`, which must lie inside.
std::uint64_t number_in(std::span<const std::byte> bytes, std::uint64_t at, std::size_t size,
                        std::endian order);

/// Recognises the format by its first bytes.
ImageKind image_kind(std::span<const std::byte> bytes);

/// "PNG", "TIFF", ...
const char* to_string(ImageKind kind);

enum class Integrity { complete, truncated, damaged };

/// PNG: chunks up to IEND, each with its checksum, and no more compressed texts than anyone writes;
/// OpenImageIO stops at the last row, checks nothing behind it, and inflates every text to 8 MB.
/// JPEG: the end marker; libjpeg misses it only where it cuts into the picture. TIFF: the entries
/// of each page's directory and of the EXIF directory hold no more than the file; libtiff makes
/// room for the same bytes once per entry, 12 GB from a file of 1.6 MB. BMP: as many rows as its
/// header claims, uncompressed; OpenImageIO makes room for the header's claims and reads no fewer.
Integrity check_integrity(std::span<const std::byte> bytes);

/// Width, height, channels and bits of a JPEG: of progressive ones libjpeg decodes all while it
/// opens them. Nothing where there is no frame header, and of other formats.
std::optional<ImageSize> jpeg_size(std::span<const std::byte> bytes);

/// Which of JPEG's processes coded it (0: baseline DCT, 3: lossless, ITU-T T.81 table B.1); nothing
/// where there is no frame header, and of other formats.
std::optional<int> jpeg_process(std::span<const std::byte> bytes);

/// A number, the first of several, of a TIFF's first directory, where TIFF/EP has what EXIF has in
/// a directory of its own; nothing where it has no such tag of type short, long, directory or
/// (signed) fraction, and of other formats.
std::optional<double> tiff_number(std::span<const std::byte> bytes, std::uint64_t tag);

/// Whether an EXR file is long enough for what its header claims: attributes, and the table of its
/// rows' places. OpenEXR makes room for both while it opens the file, 2 GB from one of 400 bytes.
/// True for other formats.
bool holds_exr_header(std::span<const std::byte> bytes);

/// Turns a JPEG's Photoshop segments into comments: OpenImageIO 2.4 reads their IPTC records for as
/// many bytes as they claim, beyond the segment's end.
void hide_photoshop_segments(std::span<std::byte> bytes);

}  // namespace kappamu::io
