#include "io/image/raw_file.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "io/image/image_integrity.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr int colour_channels = 3;

[[noreturn]] void fail(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why);
}

void note_damage(void* damaged, const char* /*file*/, const int /*offset*/) {
  *static_cast<bool*>(damaged) = true;
}

/// Numbers of EXIF tags. LibRaw's own do not do: where a file has no exposure time they give 1 s.
struct RawTags {
  std::optional<double> exposure_s, f_number, iso, focal_length_mm, shutter_speed, orientation;
};

/// Takes a tag's number into `tags`, the first where there are several. Of EXIF's directory LibRaw
/// gives the plain tag; TIFF/EP has them in a picture's directory, whose number stands above 20
/// bits of tag.
void note_tag(void* tags, int tag, int type, int count, unsigned byte_order, void* stream,
              INT64 /*base*/) {
  constexpr int short_type = 3, long_type = 4, fraction = 5, signed_fraction = 10;
  constexpr unsigned little_endian = 0x4949;
  constexpr int tag_bits = 0xFFFFF;
  static const std::map<int, std::optional<double> RawTags::*> numbers{
      {274, &RawTags::orientation},     {33434, &RawTags::exposure_s},
      {33437, &RawTags::f_number},      {34855, &RawTags::iso},
      {37377, &RawTags::shutter_speed}, {37386, &RawTags::focal_length_mm}};
  const auto found = numbers.find(tag & tag_bits);
  const std::size_t size = type == short_type                            ? 2
                           : type == long_type                           ? 4
                           : type == fraction || type == signed_fraction ? 8
                                                                         : 0;
  if (found == numbers.end() || count < 1 || size == 0) return;
  std::optional<double>& number = static_cast<RawTags*>(tags)->*(found->second);
  std::array<unsigned char, 8> bytes{};
  static_cast<LibRaw_abstract_datastream*>(stream)->read(bytes.data(), size, 1);
  const auto whole = [&](std::size_t begin, std::size_t length) {
    double value = 0.0;
    for (std::size_t i = 0; i < length; ++i) {
      value =
          256.0 * value + bytes[byte_order == little_endian ? begin + length - 1 - i : begin + i];
    }
    return type == signed_fraction && value >= 0x1p31 ? value - 0x1p32 : value;
  };
  const double value = size == 8 ? whole(0, 4) / whole(4, 4) : whole(0, size);
  const bool any_sign = found->second == &RawTags::shutter_speed;
  if (!number && std::isfinite(value) && (any_sign || value > 0.0)) number = value;
}

/// R, G, B of LibRaw's colour index, whose fourth is a second green.
int colour_of(LibRaw& raw, int row, int column, const fs::path& file) {
  const int index = raw.COLOR(row, column);
  const char letter = index < 4 ? raw.imgdata.idata.cdesc[index] : '?';
  switch (letter) {
    case 'R':
      return 0;
    case 'G':
      return 1;
    case 'B':
      return 2;
    default:
      fail(file, "the sensor's colours are not red, green and blue; only Bayer sensors are read");
  }
}

/// What LibRaw keeps of a black level that repeats over rows and columns (BlackLevelRepeatDim): the
/// numbers of both, then the levels.
double repeated_black(const libraw_colordata_t& colour, std::size_t row, std::size_t column) {
  const std::size_t rows = colour.cblack[4], columns = colour.cblack[5];
  if (rows == 0 || columns == 0) return 0.0;
  return colour.cblack[6 + row % rows * columns + column % columns];
}

/// Whether the file has uncompressed tiles, which LibRaw reads as if they were rows.
bool has_plain_tiles(LibRaw& raw) {
  const auto& data = raw.get_internal_data_pointer()->unpacker_data;
  libraw_decoder_info_t decoder{};
  raw.get_decoder_info(&decoder);
  return decoder.decoder_name == std::string("packed_dng_load_raw()") && data.tile_width > 0 &&
         data.tile_width < raw.imgdata.sizes.raw_width;
}

/// Whether one of the JPEG streams that LibRaw decodes as lossless (compression 7) is coded
/// otherwise: of cosine transforms it makes codes that no sensor gave.
bool has_lossy_jpeg(LibRaw& raw, std::span<const std::byte> bytes) {
  constexpr int lossless = 3;
  libraw_decoder_info_t decoder{};
  raw.get_decoder_info(&decoder);
  if (decoder.decoder_name != std::string("lossless_dng_load_raw()")) return false;
  const auto lossy_at = [&](std::uint64_t at) {
    return at < bytes.size() && jpeg_process(bytes.subspan(at)).value_or(lossless) != lossless;
  };
  const auto& internal = *raw.get_internal_data_pointer();
  const auto& data = internal.unpacker_data;
  const auto first = static_cast<std::uint64_t>(data.data_offset);
  const auto parts = [](unsigned size, unsigned part) { return (size + part - 1) / part; };
  const libraw_image_sizes_t& sizes = raw.imgdata.sizes;
  if (data.tile_length == 0 || data.tile_width == 0 || data.tile_length >= INT_MAX) {
    return lossy_at(first);
  }
  // Then the tiles' places are there.
  const std::uint64_t tiles = std::uint64_t{parts(sizes.raw_width, data.tile_width)} *
                              parts(sizes.raw_height, data.tile_length);
  const bool little = data.order == 0x4949;
  for (std::uint64_t at = first; at < first + 4 * tiles && at + 4 <= bytes.size(); at += 4) {
    std::uint64_t place = 0;
    for (std::uint64_t i = 0; i < 4; ++i) {
      place = place << 8 | std::to_integer<std::uint64_t>(bytes[little ? at + 3 - i : at + i]);
    }
    if (lossy_at(place)) return true;
  }
  return false;
}

/// Whether a pixel has three colours instead of one code of a mosaic: a DNG of photometric
/// interpretation "linear raw". Other formats with such pixels hold balanced or subsampled colours.
bool is_linear(LibRaw& raw) {
  const libraw_iparams_t& kind = raw.imgdata.idata;
  return kind.dng_version != 0 && kind.filters == 0 && kind.colors == colour_channels;
}

/// Nothing of a sensor without colour filters, and of a linear DNG.
std::optional<BayerLayout> layout_of(LibRaw& raw, const fs::path& file) {
  // Below 1000 LibRaw codes other things than a 2 x 2 pattern (0: none, 9: X-Trans).
  constexpr unsigned least_pattern = 1000;
  if (is_linear(raw)) return std::nullopt;
  if (raw.imgdata.idata.filters == 0 && raw.imgdata.idata.colors == 1) return std::nullopt;
  if (raw.imgdata.idata.filters < least_pattern) {
    fail(file, "not from a Bayer sensor (such as X-Trans); convert it to linear DNG, TIFF or EXR");
  }
  BayerLayout layout{};
  std::array<int, 3> sites{};
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      const int colour = colour_of(raw, y, x, file);
      layout[static_cast<std::size_t>(2 * y + x)] = colour;
      ++sites[static_cast<std::size_t>(colour)];
    }
  }
  if (sites != std::array<int, 3>{1, 2, 1}) {
    fail(file, "not from a Bayer sensor; convert it to linear DNG, TIFF or EXR");
  }
  return layout;
}

/// The visible area of what LibRaw has unpacked: `stored` codes a pixel, of which the first are the
/// channels of `codes`.
void copy_visible(const libraw_image_sizes_t& sizes, const ushort* unpacked, std::size_t stored,
                  const fs::path& file, Image<std::uint16_t>& codes) {
  const std::size_t pitch = sizes.raw_pitch / sizeof(ushort);
  if (unpacked == nullptr || sizes.left_margin + codes.width() > sizes.raw_width ||
      sizes.top_margin + codes.height() > sizes.raw_height || pitch < stored * sizes.raw_width) {
    fail(file, "truncated or damaged RAW file; copy or photograph it again");
  }
  const auto channels = static_cast<std::size_t>(codes.channels());
  for (int y = 0; y < codes.height(); ++y) {
    const ushort* pixel = unpacked + (sizes.top_margin + static_cast<std::size_t>(y)) * pitch +
                          sizes.left_margin * stored;
    for (int x = 0; x < codes.width(); ++x, pixel += stored) {
      std::copy_n(pixel, channels, &codes(x, y));
    }
  }
}

/// By the file's tags, of each channel.
std::array<double, 3> black_of(LibRaw& raw, const RawImage& image) {
  const libraw_colordata_t& colour = raw.imgdata.color;
  std::array<double, 3> black{};
  if (image.codes.channels() == colour_channels) {
    for (std::size_t channel = 0; channel < black.size(); ++channel) {
      black[channel] = colour.black + colour.cblack[channel] + repeated_black(colour, 0, 0);
    }
    return black;
  }
  for (std::size_t site = 0; site < 4; ++site) {
    const int row = static_cast<int>(site) / 2, column = static_cast<int>(site) % 2;
    const auto index = static_cast<std::size_t>(image.layout ? raw.COLOR(row, column) : 0);
    const auto channel = static_cast<std::size_t>(image.layout ? (*image.layout)[site] : 0);
    const double share = !image.layout ? 0.25 : channel == 1 ? 0.5 : 1.0;  // of its sites
    black[channel] +=
        share * (colour.black + colour.cblack[index] + repeated_black(colour, site / 2, site % 2));
  }
  return black;
}

}  // namespace

bool is_raw_file(const fs::path& file) {
  static const std::vector<std::string> endings{
      ".dng", ".cr2", ".cr3", ".crw", ".nef", ".nrw", ".arw", ".sr2", ".srf", ".orf",
      ".rw2", ".pef", ".srw", ".raf", ".3fr", ".iiq", ".erf", ".mef", ".mos", ".raw"};
  return std::find(endings.begin(), endings.end(), lower_extension(file)) != endings.end();
}

RawImage read_raw(const fs::path& file, const SizeCheck& expected) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  if (bytes.empty()) fail(file, "the file is empty");
  const auto reader = std::make_unique<LibRaw>();  // some 200 KB: not for the stack
  LibRaw& raw = *reader;
  bool damaged = false;
  raw.set_dataerror_handler(note_damage, &damaged);
  int status = raw.open_buffer(bytes.data(), bytes.size());
  if (status != LIBRAW_SUCCESS) {
    fail(file,
         std::string("not a camera RAW file that LibRaw reads (") + libraw_strerror(status) + ")");
  }
  const libraw_image_sizes_t& sizes = raw.imgdata.sizes;
  const bool linear = is_linear(raw);
  const int width = linear ? sizes.width : sizes.width / 2 * 2;
  const int height = linear ? sizes.height : sizes.height / 2 * 2;
  const int channels = linear ? colour_channels : 1;
  check_size(file, {width, height, channels}, bytes.size(), expected);
  check_size(file, {sizes.raw_width, sizes.raw_height, channels}, bytes.size(), {});  // and margins
  // LibRaw scales them to whole numbers, each photograph by its own largest, or was built without.
  if (raw.is_floating_point() != 0) {
    fail(file, "a DNG of floating point numbers; convert it to linear TIFF or EXR");
  }
  if (has_plain_tiles(raw)) {
    fail(file, "a DNG of uncompressed tiles; compress it, or convert it to linear TIFF or EXR");
  }
  if (has_lossy_jpeg(raw, bytes)) {
    fail(file,
         "holds lossy JPEG (not that of SOF3), whose codes are not the sensor's; convert it to a "
         "lossless DNG, or to linear TIFF or EXR");
  }
  status = raw.unpack();
  if (status != LIBRAW_SUCCESS || damaged) {
    fail(file, "truncated or damaged RAW file; copy or photograph it again");
  }
  const libraw_rawdata_t& unpacked = raw.imgdata.rawdata;
  if (unpacked.raw_image == nullptr && !linear) {
    fail(file,
         "holds several colours a pixel that are no linear DNG's; convert it to linear TIFF "
         "or EXR");
  }
  RawImage image;
  image.layout = layout_of(raw, file);
  image.codes = Image<std::uint16_t>(width, height, channels);
  if (!linear) {
    copy_visible(sizes, unpacked.raw_image, 1, file, image.codes);
  } else if (unpacked.color4_image != nullptr) {
    copy_visible(sizes, *unpacked.color4_image, 4, file, image.codes);
  } else {
    copy_visible(sizes, unpacked.color3_image == nullptr ? nullptr : *unpacked.color3_image, 3,
                 file, image.codes);
  }
  // Of compressed data that LibRaw does not know it makes zeros.
  const auto& codes = image.codes.values();
  if (std::all_of(codes.begin(), codes.end(), [](int code) { return code == 0; })) {
    fail(file, "every code is 0: damaged, or compressed in a way that LibRaw does not read");
  }
  image.black = black_of(raw, image);
  image.white = static_cast<int>(raw.imgdata.color.maximum);
  return image;
}

Image<std::uint16_t> read_headerless_raw(const fs::path& file, const RawLayout& layout, int width,
                                         int height) {
  const std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  const auto offset = static_cast<std::size_t>(layout.offset);
  const std::size_t code_bytes = layout.bits == 8 ? 1 : 2;
  const std::size_t expected =
      offset + code_bytes * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (bytes.size() != expected) {
    fail(file, "the file has " + std::to_string(bytes.size()) + " bytes, but " +
                   std::to_string(width) + " x " + std::to_string(height) + " codes of " +
                   std::to_string(layout.bits) + " bits from byte " + std::to_string(offset) +
                   " on have " + std::to_string(expected) +
                   "; correct width, height, bits or offset of the layout");
  }
  Image<std::uint16_t> image(width, height, 1);
  const std::byte* code = bytes.data() + offset;
  for (std::uint16_t& value : image.values()) {
    const auto first = std::to_integer<unsigned>(code[0]);
    const unsigned second = code_bytes == 1 ? 0 : std::to_integer<unsigned>(code[1]);
    value = static_cast<std::uint16_t>(code_bytes == 1     ? first
                                       : layout.big_endian ? first << 8 | second
                                                           : second << 8 | first);
    code += code_bytes;
  }
  return image;
}

PhotoSettings read_raw_settings(const fs::path& file) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  RawTags tags;
  const auto raw = std::make_unique<LibRaw>();
  raw->set_exifparser_handler(note_tag, &tags);
  if (raw->open_buffer(bytes.data(), bytes.size()) != LIBRAW_SUCCESS) return {};
  PhotoSettings settings;
  settings.exposure_s = tags.exposure_s;
  if (!tags.exposure_s && tags.shutter_speed) {
    settings.exposure_s = exposure_of_speed(*tags.shutter_speed);
  }
  settings.f_number = tags.f_number;
  settings.iso = tags.iso;
  settings.focal_length_mm = tags.focal_length_mm;
  if (tags.orientation && *tags.orientation <= 8.0) {
    settings.orientation = static_cast<int>(*tags.orientation);
  }
  settings.camera = raw->imgdata.idata.model;
  return settings;
}

}  // namespace kappamu::io
