#include "io/image/image_integrity.h"

#include <isa-l/crc.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <string_view>

namespace kappamu::io {

namespace {

using Bytes = std::span<const std::byte>;

bool starts_with(Bytes bytes, const char* text, std::size_t size) {
  return bytes.size() >= size && std::memcmp(bytes.data(), text, size) == 0;
}

/// Chunks of length, type, data, checksum of type and data, until IEND (PNG specification,
/// section 5).
Integrity check_png(Bytes bytes) {
  constexpr int most_texts = 16;  // 128 MB inflated
  int texts = 0;
  std::uint64_t at = 8;
  while (at + 12 <= bytes.size()) {
    const std::uint64_t length = number_in(bytes, at, 4, std::endian::big);
    if (length >> 31 != 0) return Integrity::damaged;
    if (at + 12 + length > bytes.size()) return Integrity::truncated;
    const auto* type = reinterpret_cast<const unsigned char*>(bytes.data() + at + 4);
    if (crc32_gzip_refl(0, type, length + 4) !=
        number_in(bytes, at + 8 + length, 4, std::endian::big)) {
      return Integrity::damaged;
    }
    if (std::memcmp(type, "IEND", 4) == 0) return Integrity::complete;
    if (std::memcmp(type, "zTXt", 4) == 0 || std::memcmp(type, "iTXt", 4) == 0) ++texts;
    if (texts > most_texts) return Integrity::damaged;
    at += 12 + length;
  }
  return Integrity::truncated;
}

/// Calls `visit`(marker, offset of the segment) for each marker segment of a JPEG up to its first
/// scan (ITU T.81, annex B), and gives the offset where the scan's data begin; nothing where
/// libjpeg would have to search for the next marker.
template <class Visit>
std::optional<std::uint64_t> walk_jpeg(Bytes bytes, const Visit& visit) {
  constexpr std::uint64_t start_of_scan = 0xDA;
  std::uint64_t at = 2;
  while (at + 4 <= bytes.size()) {
    const std::uint64_t marker = number_in(bytes, at + 1, 1, std::endian::big);
    const std::uint64_t length = number_in(bytes, at + 2, 2, std::endian::big);
    if (bytes[at] != std::byte{0xFF}) return std::nullopt;
    if (marker == 0xFF) {  // a fill byte
      ++at;
      continue;
    }
    if (marker < 0xC0 || (marker >= 0xD0 && marker <= 0xD9) || length < 2) return std::nullopt;
    visit(marker, at);
    at += 2 + length;
    if (marker == start_of_scan) return at;
  }
  return bytes.size();
}

/// 0xC0 to 0xCF, but for 4, 8 and 12, which are tables.
bool starts_frame(std::uint64_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && (marker % 4 != 0 || marker == 0xC0);
}

/// An end-of-image marker behind the beginning of the first scan: coded data never contain one.
Integrity check_jpeg(Bytes bytes) {
  constexpr std::byte end_of_image{0xD9};
  const std::optional<std::uint64_t> scan = walk_jpeg(bytes, [](auto, auto) {});
  if (!scan) return Integrity::damaged;
  for (std::uint64_t at = *scan; at + 1 < bytes.size(); ++at) {
    if (bytes[at] == std::byte{0xFF} && bytes[at + 1] == end_of_image) return Integrity::complete;
  }
  return Integrity::truncated;
}

/// File header of 14 bytes, information header of 40 or more, palette, rows (Windows
/// BITMAPFILEHEADER and BITMAPINFOHEADER to BITMAPV5HEADER). Of 8 bits with a palette, 24 or 32
/// bits.
Integrity check_bmp(Bytes bytes) {
  constexpr std::uint64_t header = 14, information = 40, most_colours = 256;
  constexpr std::int64_t largest_side = 1 << 16;
  if (bytes.size() < header + information) return Integrity::truncated;
  const auto at = [&](std::uint64_t place, std::size_t size) {
    return number_in(bytes, place, size, std::endian::little);
  };
  const auto side = [&](std::uint64_t place) {  // rows from the top are a negative height
    return std::abs(std::int64_t{static_cast<std::int32_t>(at(place, 4))});
  };
  const std::uint64_t begin = at(10, 4), bits = at(28, 2), compression = at(30, 4);
  const std::int64_t width = side(18), height = side(22);
  const bool plain = compression == 0 || (compression == 3 && bits == 32);
  if (at(14, 4) < information || at(26, 2) != 1 || !plain ||
      (bits != 8 && bits != 24 && bits != 32) || at(46, 4) > most_colours || width < 1 ||
      height < 1 || width > largest_side || height > largest_side) {
    return Integrity::damaged;
  }
  const std::uint64_t row = (static_cast<std::uint64_t>(width) * bits + 31) / 32 * 4;
  const std::uint64_t pixels = row * static_cast<std::uint64_t>(height);
  return begin <= bytes.size() && pixels <= bytes.size() - begin ? Integrity::complete
                                                                 : Integrity::truncated;
}

struct TiffFormat {
  std::endian order = std::endian::little;
  bool big_tiff = false;
};
constexpr std::uint64_t exif_tag = 34665;

/// The TIFF directory at `at` (TIFF 6.0, section 2) and the one that `child_tag` leads to; `at`
/// then is where the next begins, 0 behind the last. Entries of tag, type, count and value have 12
/// bytes, or 20 in BigTIFF.
Integrity check_directory(Bytes bytes, std::uint64_t& at, TiffFormat format,
                          std::optional<std::uint64_t> child_tag) {
  const auto [order, big_tiff] = format;
  constexpr std::array<std::uint64_t, 19> type_sizes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4,
                                                     8, 4, 8, 4, 0, 0, 8, 8, 8};
  const std::size_t word = big_tiff ? 8 : 4;
  const std::size_t head = big_tiff ? 8 : 2;
  const std::size_t entry_size = 4 + 2 * word;
  if (at > bytes.size() || bytes.size() - at < head) return Integrity::truncated;
  const std::uint64_t entries = number_in(bytes, at, head, order);
  if (entries > (bytes.size() - at - head) / entry_size) return Integrity::truncated;
  std::uint64_t total = 0;
  for (std::uint64_t e = 0; e < entries; ++e) {
    const std::uint64_t entry = at + head + e * entry_size;
    const std::uint64_t tag = number_in(bytes, entry, 2, order);
    const std::uint64_t type = number_in(bytes, entry + 2, 2, order);
    const std::uint64_t count = number_in(bytes, entry + 4, word, order);
    if (count > bytes.size()) return Integrity::truncated;
    total += type < type_sizes.size() ? count * type_sizes[type] : 0;
    if (total > bytes.size()) return Integrity::damaged;
    std::uint64_t offset = number_in(bytes, entry + 4 + word, word, order);
    if (child_tag == tag) {
      child_tag.reset();  // libtiff ignores a second one
      const Integrity child = check_directory(bytes, offset, format, std::nullopt);
      if (child != Integrity::complete) return child;
    }
  }
  const std::uint64_t next = at + head + entries * entry_size;
  at = next + word <= bytes.size() ? number_in(bytes, next, word, order) : 0;
  return Integrity::complete;
}

/// Of at least 16 bytes.
TiffFormat tiff_format(Bytes bytes) {
  TiffFormat format{bytes[0] == std::byte{'M'} ? std::endian::big : std::endian::little, false};
  format.big_tiff = number_in(bytes, 2, 2, format.order) == 43;
  return format;
}

Integrity check_tiff(Bytes bytes) {
  if (bytes.size() < 16) return Integrity::truncated;
  const TiffFormat format = tiff_format(bytes);
  std::uint64_t directory =
      format.big_tiff ? number_in(bytes, 8, 8, format.order) : number_in(bytes, 4, 4, format.order);
  constexpr int most_pages = 1000;
  for (int page = 0; page < most_pages; ++page) {
    const Integrity integrity = check_directory(bytes, directory, format, exif_tag);
    if (integrity != Integrity::complete || directory == 0) return integrity;
  }
  return Integrity::damaged;
}

}  // namespace

std::uint64_t number_in(Bytes bytes, std::uint64_t at, std::size_t size, std::endian order) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t k = order == std::endian::big ? i : size - 1 - i;
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + k]);
  }
  return value;
}

ImageKind image_kind(Bytes bytes) {
  if (starts_with(bytes, "\x89PNG\r\n\x1a\n", 8)) return ImageKind::png;
  if (starts_with(bytes, "II", 2) || starts_with(bytes, "MM", 2)) return ImageKind::tiff;
  if (starts_with(bytes, "\xFF\xD8\xFF", 3)) return ImageKind::jpeg;
  if (starts_with(bytes, "BM", 2)) return ImageKind::bmp;
  if (starts_with(bytes, "\x76\x2f\x31\x01", 4)) return ImageKind::exr;
  if (starts_with(bytes, "#?", 2)) return ImageKind::radiance;
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
    case ImageKind::bmp:
      return "BMP";
    case ImageKind::exr:
      return "EXR";
    case ImageKind::radiance:
      return "Radiance";
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
    case ImageKind::bmp:
      return check_bmp(bytes);
    case ImageKind::tiff:
      return check_tiff(bytes);
    default:
      return Integrity::complete;
  }
}

std::optional<double> tiff_number(Bytes bytes, std::uint64_t tag) {
  constexpr std::uint64_t short_type = 3, long_type = 4, fraction = 5, signed_fraction = 10;
  constexpr std::uint64_t directory_type = 13, long8_type = 16, directory8_type = 18;
  if (image_kind(bytes) != ImageKind::tiff || check_tiff(bytes) != Integrity::complete) return {};
  const TiffFormat format = tiff_format(bytes);
  const std::endian order = format.order;
  const std::size_t word = format.big_tiff ? 8 : 4, head = format.big_tiff ? 8 : 2;
  const std::uint64_t directory = number_in(bytes, word, word, order);
  const std::uint64_t entries = number_in(bytes, directory, head, order);
  for (std::uint64_t e = 0; e < entries; ++e) {
    const std::uint64_t entry = directory + head + e * (4 + 2 * word);
    if (number_in(bytes, entry, 2, order) != tag) continue;
    const std::uint64_t type = number_in(bytes, entry + 2, 2, order);
    const bool is_fraction = type == fraction || type == signed_fraction;
    const bool is_long = type == long_type || type == directory_type;
    const bool is_long8 = type == long8_type || type == directory8_type;
    if (type != short_type && !is_long && !is_long8 && !is_fraction) return {};
    const std::size_t size = type == short_type ? 2 : is_long ? 4 : 8;
    std::uint64_t at = entry + 4 + word;
    // Values of more bytes than fit there lie elsewhere.
    if (number_in(bytes, entry + 4, word, order) * size > word)
      at = number_in(bytes, at, word, order);
    if (at > bytes.size() || bytes.size() - at < size) return {};
    if (!is_fraction) return static_cast<double>(number_in(bytes, at, size, order));
    const auto whole = [&](std::uint64_t place) {
      const auto value = static_cast<std::uint32_t>(number_in(bytes, place, 4, order));
      return type == fraction ? static_cast<double>(value)
                              : static_cast<double>(static_cast<std::int32_t>(value));
    };
    return whole(at) / whole(at + 4);
  }
  return {};
}

std::optional<int> jpeg_process(Bytes bytes) {
  std::optional<int> process;
  if (image_kind(bytes) != ImageKind::jpeg) return process;
  walk_jpeg(bytes, [&](std::uint64_t marker, std::uint64_t) {
    if (!process && starts_frame(marker)) process = static_cast<int>(marker - 0xC0);
  });
  return process;
}

std::optional<ImageSize> jpeg_size(Bytes bytes) {
  std::optional<ImageSize> size;
  if (image_kind(bytes) != ImageKind::jpeg) return size;
  walk_jpeg(bytes, [&](std::uint64_t marker, std::uint64_t at) {
    if (!starts_frame(marker) || at + 10 > bytes.size()) return;
    size = {static_cast<int>(number_in(bytes, at + 7, 2, std::endian::big)),
            static_cast<int>(number_in(bytes, at + 5, 2, std::endian::big)),
            static_cast<int>(number_in(bytes, at + 9, 1, std::endian::big)),
            static_cast<int>(number_in(bytes, at + 4, 1, std::endian::big))};
  });
  return size;
}

/// Whether OpenEXR's reader of the attribute's type takes exactly the bytes of its value: those of
/// a fixed size do not look at the length, lists of channels end with an empty name.
bool has_exr_length(std::string_view type, Bytes value) {
  static const std::map<std::string_view, std::size_t> sizes{{"box2f", 16},
                                                             {"box2i", 16},
                                                             {"chromaticities", 32},
                                                             {"compression", 1},
                                                             {"deepImageState", 1},
                                                             {"double", 8},
                                                             {"envmap", 1},
                                                             {"float", 4},
                                                             {"int", 4},
                                                             {"keycode", 28},
                                                             {"lineOrder", 1},
                                                             {"m33d", 72},
                                                             {"m33f", 36},
                                                             {"m44d", 128},
                                                             {"m44f", 64},
                                                             {"rational", 8},
                                                             {"tiledesc", 9},
                                                             {"timecode", 8},
                                                             {"v2d", 16},
                                                             {"v2f", 8},
                                                             {"v2i", 8},
                                                             {"v3d", 24},
                                                             {"v3f", 12},
                                                             {"v3i", 12}};
  if (const auto fixed = sizes.find(type); fixed != sizes.end()) {
    return value.size() == fixed->second;
  }
  if (type != "chlist") return true;
  constexpr std::size_t channel = 16;  // [bytes] behind its name
  while (!value.empty() && value.front() != std::byte{0}) {
    const auto end = std::find(value.begin(), value.end(), std::byte{0});
    const auto name = static_cast<std::size_t>(end - value.begin());
    if (value.size() < name + 1 + channel) return false;
    value = value.subspan(name + 1 + channel);
  }
  return value.size() == 1;
}

/// The header is a list of attributes (name, type, size, value) that ends with an empty name; of a
/// file of several parts there is a list of such lists (OpenEXR file layout).
bool holds_exr_header(Bytes bytes) {
  constexpr std::int64_t rows_per_entry = 256;  // at most, of any compression
  constexpr std::size_t entry = 8;              // [bytes]
  constexpr std::uint64_t least_channel = 18;   // [bytes] of a channel, its name included
  // Before the size is compared with what is expected, OpenEXR makes room for a block of rows.
  constexpr std::int64_t most_values_in_row = 1 << 19;
  if (image_kind(bytes) != ImageKind::exr) return true;
  const bool several_parts = bytes.size() > 5 && (bytes[5] & std::byte{0x10}) != std::byte{0};
  const auto text_at = [&](std::uint64_t at) {
    const auto end =
        std::find(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(), std::byte{0});
    return std::string_view(reinterpret_cast<const char*>(bytes.data()) + at,
                            static_cast<std::size_t>(end - bytes.begin()) - at);
  };
  std::int64_t rows = 0, columns = 0, channels = 1;
  for (std::uint64_t at = 8; at + 1 < bytes.size();) {
    if (bytes[at] == std::byte{0}) {  // the end of a header
      if (!several_parts || bytes[++at] == std::byte{0}) break;
      continue;
    }
    const std::string_view name = text_at(at);
    if (at + name.size() + 1 > bytes.size()) return false;
    const std::string_view type = text_at(at + name.size() + 1);
    const std::uint64_t size = at + name.size() + 1 + type.size() + 1;
    if (size + 4 > bytes.size()) return false;
    const std::uint64_t value = size + 4;
    const std::uint64_t length = number_in(bytes, size, 4, std::endian::little);
    if (value + length > bytes.size()) return false;
    if (!has_exr_length(type, bytes.subspan(value, length))) return false;
    if (length == 16 && name == "dataWindow") {
      const auto signed_number = [&](std::uint64_t offset) {
        return std::int64_t{
            static_cast<std::int32_t>(number_in(bytes, value + offset, 4, std::endian::little))};
      };
      rows = std::max(rows, signed_number(12) - signed_number(4) + 1);
      columns = std::max(columns, signed_number(8) - signed_number(0) + 1);
    }
    if (type == "chlist") {
      channels = std::max(channels, static_cast<std::int64_t>(length / least_channel));
    }
    at = value + length;
  }
  return columns <= most_values_in_row / channels &&
         static_cast<std::uint64_t>(rows / rows_per_entry) * entry <= bytes.size();
}

void hide_photoshop_segments(std::span<std::byte> bytes) {
  constexpr std::uint64_t photoshop = 0xED;
  constexpr std::byte comment{0xFE};
  if (image_kind(bytes) != ImageKind::jpeg) return;
  walk_jpeg(bytes, [&](std::uint64_t marker, std::uint64_t at) {
    if (marker == photoshop) bytes[at + 1] = comment;
  });
}

}  // namespace kappamu::io
