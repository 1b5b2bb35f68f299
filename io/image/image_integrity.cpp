#include "io/image/image_integrity.h"

#include <zlib.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

namespace kappamu::io {

namespace {

using Bytes = std::span<const std::byte>;

bool starts_with(Bytes bytes, const char* text, std::size_t size) {
  return bytes.size() >= size && std::memcmp(bytes.data(), text, size) == 0;
}

/// Unsigned number of `size` bytes at `at`, which must lie inside.
std::uint64_t number(Bytes bytes, std::uint64_t at, std::size_t size, bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t k = big_endian ? i : size - 1 - i;
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + k]);
  }
  return value;
}

/// Chunks of length, type, data, checksum of type and data, until IEND (PNG specification,
/// section 5).
Integrity check_png(Bytes bytes) {
  std::uint64_t at = 8;
  constexpr std::uint64_t header_end = 24;  // of width and height, which are the first chunk's
  if (bytes.size() >= header_end &&
      claims_too_much(number(bytes, 16, 4, true) * number(bytes, 20, 4, true), bytes.size())) {
    return Integrity::damaged;
  }
  while (at + 12 <= bytes.size()) {
    const std::uint64_t length = number(bytes, at, 4, true);
    if (length >> 31 != 0) return Integrity::damaged;
    if (at + 12 + length > bytes.size()) return Integrity::truncated;
    const auto* type = reinterpret_cast<const unsigned char*>(bytes.data() + at + 4);
    if (::crc32(0, type, static_cast<unsigned>(length + 4)) !=
        number(bytes, at + 8 + length, 4, true)) {
      return Integrity::damaged;
    }
    if (std::memcmp(type, "IEND", 4) == 0) return Integrity::complete;
    at += 12 + length;
  }
  return Integrity::truncated;
}

/// Marker segments up to the first scan, then an end-of-image marker (ITU T.81, annex B; coded data
/// never contains one).
Integrity check_jpeg(Bytes bytes) {
  constexpr std::uint64_t first_frame = 0xC0;  // to 0xCF, but for 4, 8 and 12
  constexpr std::uint64_t start_of_scan = 0xDA;
  constexpr std::byte end_of_image{0xD9};
  std::uint64_t at = 2;
  while (at + 4 <= bytes.size()) {
    const std::uint64_t marker = number(bytes, at + 1, 1, true);
    if ((marker == first_frame || (marker / 16 == first_frame / 16 && marker % 4 != 0)) &&
        at + 9 <= bytes.size() &&
        claims_too_much(number(bytes, at + 5, 2, true) * number(bytes, at + 7, 2, true),
                        bytes.size())) {
      return Integrity::damaged;
    }
    at += 2 + number(bytes, at + 2, 2, true);
    if (marker == start_of_scan) break;
  }
  for (; at + 1 < bytes.size(); ++at) {
    if (bytes[at] == std::byte{0xFF} && bytes[at + 1] == end_of_image) return Integrity::complete;
  }
  return Integrity::truncated;
}

/// The first directory and the strips or tiles it names lie inside the file (TIFF 6.0, section 2).
/// BigTIFF is left to the decoder.
Integrity check_tiff(Bytes bytes) {
  if (bytes.size() < 8) return Integrity::truncated;
  const bool big = bytes[0] == std::byte{'M'};
  const auto has = [&](std::uint64_t at, std::uint64_t size) {
    return size <= bytes.size() && at <= bytes.size() - size;
  };
  if (number(bytes, 2, 2, big) != 42) return Integrity::complete;
  const std::uint64_t directory = number(bytes, 4, 4, big);
  if (!has(directory, 2)) return Integrity::truncated;
  const std::uint64_t entries = number(bytes, directory, 2, big);
  if (!has(directory + 2, entries * 12)) return Integrity::truncated;

  std::array<std::uint64_t, 2> extent{};
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint64_t> sizes;
  for (std::uint64_t e = 0; e < entries; ++e) {
    const std::uint64_t at = directory + 2 + e * 12;
    const std::uint64_t tag = number(bytes, at, 2, big);
    const std::size_t width = number(bytes, at + 2, 2, big) == 3 ? 2 : 4;  // SHORT or LONG
    if (tag == 256 || tag == 257) {  // ImageWidth, ImageLength
      extent[tag - 256] = number(bytes, at + 8, width, big);
    }
    const bool is_offset = tag == 273 || tag == 324;  // StripOffsets, TileOffsets
    const bool is_size = tag == 279 || tag == 325;    // StripByteCounts, TileByteCounts
    if (!is_offset && !is_size) continue;
    const std::uint64_t count = number(bytes, at + 4, 4, big);
    const std::uint64_t list = count * width <= 4 ? at + 8 : number(bytes, at + 8, 4, big);
    if (!has(list, count * width)) return Integrity::truncated;
    for (std::uint64_t i = 0; i < count; ++i) {
      (is_offset ? offsets : sizes).push_back(number(bytes, list + i * width, width, big));
    }
  }
  if (claims_too_much(extent[0] * extent[1], bytes.size())) return Integrity::damaged;
  if (offsets.empty() || offsets.size() != sizes.size()) return Integrity::truncated;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (!has(offsets[i], sizes[i])) return Integrity::truncated;
  }
  return Integrity::complete;
}

}  // namespace

ImageKind image_kind(Bytes bytes) {
  if (starts_with(bytes, "\x89PNG\r\n\x1a\n", 8)) return ImageKind::png;
  if (starts_with(bytes, "II", 2) || starts_with(bytes, "MM", 2)) return ImageKind::tiff;
  if (starts_with(bytes, "\xFF\xD8\xFF", 3)) return ImageKind::jpeg;
  if (starts_with(bytes, "\x76\x2f\x31\x01", 4)) return ImageKind::exr;
  return ImageKind::unknown;
}

const char* to_string(ImageKind kind) {
  switch (kind) {
    case ImageKind::png:
      return "PNG";
    case ImageKind::tiff:
      return "TIFF";
    case ImageKind::jpeg:
      return "JPEG";
    case ImageKind::exr:
      return "EXR";
    default:
      return "unknown";
  }
}

Integrity check_integrity(Bytes bytes) {
  switch (image_kind(bytes)) {
    case ImageKind::png:
      return check_png(bytes);
    case ImageKind::jpeg:
      return check_jpeg(bytes);
    case ImageKind::tiff:
      return check_tiff(bytes);
    default:
      return Integrity::complete;
  }
}

bool claims_too_much(std::uint64_t numbers, std::size_t bytes) {
  constexpr std::uint64_t always_allowed = std::uint64_t{1} << 22;
  constexpr std::uint64_t per_byte = 1024;  // about what deflate makes of zeros
  return numbers > always_allowed && numbers / per_byte > bytes;
}

}  // namespace kappamu::io
