#include "io/image/picture_values.h"

#include <algorithm>
#include <map>
#include <span>
#include <string>

#include "core/error.h"
#include "io/image/image_integrity.h"
#include "io/image/oiio_input.h"
#include "io/image/png_reader.h"
#include "io/image/tiff_pages.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void reject(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why);
}

/// The file is whole, as far as its structure says, and its library does not decode it.
[[noreturn]] void reject_undecoded(const fs::path& file, ImageKind kind) {
  reject(file, std::string("damaged ") + to_string(kind) +
                   " image, or compressed in an unusual way; copy it again or save it as a "
                   "plain PNG or TIFF");
}

/// The pages that are neither previews nor masks (NewSubfileType, TIFF 6.0, section 8); of a single
/// page that one, unless the full picture lies in a directory below it (SubIFDs, TIFF/EP).
std::vector<int> full_pages(OiioInput& input, const fs::path& file,
                            std::span<const std::byte> bytes) {
  constexpr int reduced = 1, mask = 4;
  constexpr std::uint64_t sub_directories = 330;
  std::vector<int> full;
  int pages = 0;
  for (; input.select(pages); ++pages) {
    const int type = input.spec().get_int_attribute("tiff:subfiletype", 0);
    if ((type & (reduced | mask)) == 0) full.push_back(pages);
  }
  if (full.empty() && (pages > 1 || tiff_number(bytes, sub_directories))) {
    reject(file, "holds previews and masks only; save the full picture");
  }
  if (full.empty()) full.push_back(0);
  return full;
}

/// Goes to the only full page.
void select_page(OiioInput& input, const fs::path& file, std::span<const std::byte> bytes) {
  const std::vector<int> full = full_pages(input, file, bytes);
  if (full.size() > 1) {
    reject(file, "holds " + std::to_string(full.size()) +
                     " full pictures (pages); save the one that is meant as a file of its own");
  }
  input.select(full.front());
}

/// Throws where the file's values are something else than grey or R, G, B: OpenImageIO converts
/// them, or leaves them as they are.
void check_colours(const OIIO::ImageSpec& spec, const fs::path& file) {
  static const std::map<int, const char*> others{{0, "white as code 0 (MinIsWhite)"},
                                                 {3, "palette colours"},
                                                 {4, "a mask"},
                                                 {5, "CMYK inks"},
                                                 {6, "YCbCr colours"},
                                                 {8, "CIE Lab colours"},
                                                 {9, "ICC Lab colours"},
                                                 {10, "ITU Lab colours"},
                                                 {32803, "a sensor's mosaic"},
                                                 {34892, "a sensor's linear colours"}};
  const int photometric = spec.get_int_attribute("tiff:PhotometricInterpretation", 1);
  const bool cmyk = spec.get_string_attribute("jpeg:ColorSpace") == "CMYK" || spec.nchannels == 4;
  const auto found = others.find(photometric);
  const char* what = found != others.end()                ? found->second
                     : photometric < 0 || photometric > 2 ? "colours of an unknown kind"
                     : cmyk && spec.alpha_channel < 0     ? "CMYK inks or a fourth colour"
                                                          : nullptr;
  if (what == nullptr) return;
  reject(file, std::string("holds ") + what + "; save it as grey, black as 0, or RGB");
}

int colours(const OIIO::ImageSpec& spec) {
  const bool has_alpha = spec.nchannels > 1 && spec.alpha_channel == spec.nchannels - 1;
  return spec.nchannels - (has_alpha ? 1 : 0);
}

void check_channels(const OIIO::ImageSpec& spec, const fs::path& file) {
  const int channels = colours(spec);
  if (channels != 1 && channels != 3) {
    reject(file, "holds " + std::to_string(channels) + " channels; save it as grey or RGB");
  }
  if (spec.depth != 1) reject(file, "holds a volume; save its slice as a picture of its own");
}

int bits_of(const OIIO::ImageSpec& spec, const fs::path& file) {
  const int bits = spec.get_int_attribute("oiio:BitsPerSample", 8);
  const OIIO::TypeDesc format = spec.format;
  const bool codes = format == OIIO::TypeUInt8 || format == OIIO::TypeUInt16;
  if (codes && (bits == 8 || bits == 16)) return format == OIIO::TypeUInt8 ? 8 : 16;
  const std::string what = format.is_floating_point() ? "floats"
                           : format.is_signed()       ? "signed whole numbers"
                                                      : "whole numbers";
  reject(file, "holds " + what + " of " + std::to_string(codes ? bits : 8 * format.size()) +
                   " bits; save it with 8 or 16 bits per channel, without sign");
}

/// Hands over the rows of the opened picture, of the channels that are colours; of `part` alone,
/// where given.
template <class Value, class TakeRow>
void read_rows(OiioInput& input, const fs::path& file, ImageKind kind,
               const std::optional<Region>& part, const TakeRow& take_row) {
  const OIIO::ImageSpec& spec = input.spec();
  const auto stored = static_cast<std::size_t>(spec.nchannels);
  const Region wanted = part.value_or(Region{0, 0, spec.width, spec.height});
  const auto kept = static_cast<std::size_t>(colours(spec));
  // 8-bit codes keep their values: OpenImageIO scales where it converts.
  const bool bytes = std::is_integral_v<Value> && spec.format == OIIO::TypeUInt8;
  std::vector<Value> values(static_cast<std::size_t>(wanted.width) * kept);
  const auto copy = [&]<class Stored>(const Stored* from) {
    if (stored == kept) {
      std::copy_n(from, values.size(), values.data());
      return;
    }
    Value* to = values.data();
    for (int x = 0; x < wanted.width; ++x, from += stored, to += kept) std::copy_n(from, kept, to);
  };
  const auto take = [&](int first, int rows, const std::byte* from) {
    for (int row = std::max(first, wanted.top); row < std::min(first + rows, wanted.bottom());
         ++row) {
      const std::size_t at =
          (static_cast<std::size_t>(row - first) * spec.width + wanted.left) * stored;
      if (bytes) {
        copy(reinterpret_cast<const std::uint8_t*>(from) + at);
      } else {
        copy(reinterpret_cast<const Value*>(from) + at);
      }
      take_row(row - wanted.top, values.data());
    }
  };
  const OIIO::TypeDesc format =
      bytes ? OIIO::TypeUInt8 : OIIO::TypeDesc(OIIO::BaseTypeFromC<Value>::value);
  if (!input.read(format, take, wanted.bottom())) reject_undecoded(file, kind);
}

template <class Value>
Image<Value> read_values(OiioInput& input, const fs::path& file, ImageKind kind,
                         const std::optional<Region>& part = {}) {
  const OIIO::ImageSpec& spec = input.spec();
  Image<Value> image(part ? part->width : spec.width, part ? part->height : spec.height,
                     colours(spec));
  const std::size_t row =
      static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.channels());
  read_rows<Value>(input, file, kind, part,
                   [&](int y, const Value* values) { std::copy_n(values, row, &image(0, y)); });
  return image;
}

void check_extent(const OIIO::ImageSpec& spec, const fs::path& file, std::size_t bytes, int bits,
                  const SizeCheck& expected) {
  const int channels = colours(spec);
  check_size(file, {spec.width, spec.height, channels, bits}, bytes, expected);
  if (spec.tile_width > 0) {
    check_size(file, {spec.tile_width, spec.tile_height, channels}, bytes, {});
  }
}

void check_structure(std::span<const std::byte> bytes, const fs::path& file, ImageKind kind) {
  const Integrity integrity = check_integrity(bytes);
  if (integrity == Integrity::complete) return;
  if (kind == ImageKind::bmp && integrity == Integrity::damaged) reject_undecoded(file, kind);
  reject(file, std::string(integrity == Integrity::truncated ? "truncated " : "damaged ") +
                   to_string(kind) + " image; copy or photograph it again");
}

/// A picture of codes, checked and opened.
struct OpenedCodes {
  ImageSize size;
  std::function<void(const std::optional<Region>& part, const TakeCodeRow& take)> read_rows;
};

/// Calls act(opened) with the picture of codes.
void with_codes(const fs::path& file, const SizeCheck& expected,
                const std::function<void(const OpenedCodes& opened)>& act) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  const ImageKind kind = image_kind(bytes);
  if (bytes.empty()) reject(file, "the file is empty");
  if (kind == ImageKind::unknown) {
    reject(file, "not a PNG, TIFF, JPEG or BMP image; convert it to one of them");
  }
  if (kind == ImageKind::exr || kind == ImageKind::radiance) {
    reject(file, std::string("not a PNG, TIFF, JPEG or BMP image but ") + to_string(kind) +
                     "; give it that format's ending");
  }
  check_structure(bytes, file, kind);
  if (const auto png = kind == ImageKind::png ? PlainPng::open(bytes) : std::nullopt) {
    check_size(file, png->size(), bytes.size(), expected);
    act({png->size(), [&](const std::optional<Region>& part, const TakeCodeRow& take) {
           const Region wanted = part.value_or(Region{0, 0, png->size().width, png->size().height});
           const auto skipped = static_cast<std::size_t>(wanted.left) *
                                static_cast<std::size_t>(png->size().channels);
           const bool read = png->read(wanted.bottom(), [&](int y, const std::uint16_t* codes) {
             if (y >= wanted.top) take(y - wanted.top, codes + skipped);
           });
           if (!read) reject_undecoded(file, kind);
         }});
    return;
  }
  if (const auto size = jpeg_size(bytes)) {
    check_size(file, *size, bytes.size(), expected);
    if (size->bits > 8) {
      reject(file, "holds " + std::to_string(size->bits) +
                       " bits per channel, which JPEG readers do not take; save it as a 16-bit "
                       "PNG or TIFF");
    }
  }
  OiioInput input(file, bytes);
  if (!input.opened()) reject_undecoded(file, kind);
  if (kind == ImageKind::tiff) select_page(input, file, bytes);
  const OIIO::ImageSpec& spec = input.spec();
  check_colours(spec, file);
  check_channels(spec, file);
  const int bits = bits_of(spec, file);
  check_extent(spec, file, bytes.size(), bits, expected);
  act({{spec.width, spec.height, colours(spec), bits},
       [&](const std::optional<Region>& part, const TakeCodeRow& take) {
         read_rows<std::uint16_t>(input, file, kind, part, take);
       }});
}

}  // namespace

CodePicture read_codes(const fs::path& file, const SizeCheck& expected,
                       const std::optional<Region>& part) {
  CodePicture picture;
  with_codes(file, expected, [&](const OpenedCodes& opened) {
    const ImageSize& size = opened.size;
    picture.bits = size.bits;
    picture.codes = Image<std::uint16_t>(part ? part->width : size.width,
                                         part ? part->height : size.height, size.channels);
    const std::size_t row =
        static_cast<std::size_t>(picture.codes.width()) * static_cast<std::size_t>(size.channels);
    opened.read_rows(part, [&](int y, const std::uint16_t* codes) {
      std::copy_n(codes, row, &picture.codes(0, y));
    });
  });
  return picture;
}

void read_code_rows(const fs::path& file, const SizeCheck& expected,
                    const std::optional<Region>& part, const TakeCodeRow& take) {
  with_codes(file, expected, [&](const OpenedCodes& opened) { opened.read_rows(part, take); });
}

bool is_float_tiff(std::span<const std::byte> bytes) {
  constexpr std::uint64_t sample_format = 339;
  constexpr double floats = 3.0;
  return tiff_number(bytes, sample_format) == floats;
}

namespace {

/// Of a TIFF whose structure is whole.
std::vector<std::byte> tiff_bytes(const fs::path& file) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  if (image_kind(bytes) != ImageKind::tiff) reject(file, "is no TIFF file; save it as one");
  check_structure(bytes, file, ImageKind::tiff);
  return bytes;
}

/// Floats of the selected page.
Image<float> selected_floats(OiioInput& input, const fs::path& file, std::size_t bytes,
                             const SizeCheck& expected) {
  check_colours(input.spec(), file);
  check_channels(input.spec(), file);
  if (!input.spec().format.is_floating_point()) {
    reject(file, "its picture holds no floats, its first page does; save the picture alone");
  }
  // OpenImageIO 2.4 reads zeros from rows of doubles.
  if (input.spec().format == OIIO::TypeDesc::DOUBLE) {
    reject(file, "holds floats of 64 bits; save it with 32");
  }
  check_extent(input.spec(), file, bytes, 0, expected);
  return read_values<float>(input, file, ImageKind::tiff);
}

}  // namespace

Image<float> read_tiff_floats(const fs::path& file, std::vector<std::byte>& bytes,
                              const SizeCheck& expected) {
  check_structure(bytes, file, ImageKind::tiff);
  OiioInput input(file, bytes);
  if (!input.opened()) reject_undecoded(file, ImageKind::tiff);
  select_page(input, file, bytes);
  return selected_floats(input, file, bytes.size(), expected);
}

struct TiffPages::Opened {
  explicit Opened(const fs::path& name) : file(name), bytes(tiff_bytes(name)), input(name, bytes) {
    if (!input.opened()) reject_undecoded(file, ImageKind::tiff);
    full = full_pages(input, file, bytes);
  }

  fs::path file;
  std::vector<std::byte> bytes;
  OiioInput input;
  std::vector<int> full;  ///< pages of the file
};

TiffPages::TiffPages(const fs::path& file) : opened_(std::make_unique<Opened>(file)) {}
TiffPages::~TiffPages() = default;

std::size_t TiffPages::count() const {
  return opened_->full.size();
}
std::size_t TiffPages::bytes() const {
  return opened_->bytes.size();
}

Image<float> TiffPages::read(std::size_t page) {
  auto& [file, bytes, input, full] = *opened_;
  if (page >= full.size()) {
    reject(file, "has pages 0 to " + std::to_string(full.size() - 1) + ", no page " +
                     std::to_string(page));
  }
  input.select(full[page]);
  if (input.spec().format.is_floating_point()) {
    return selected_floats(input, file, bytes.size(), {});
  }
  check_colours(input.spec(), file);
  check_channels(input.spec(), file);
  check_extent(input.spec(), file, bytes.size(), bits_of(input.spec(), file), {});
  const auto codes = read_values<std::uint16_t>(input, file, ImageKind::tiff);
  Image<float> picture(codes.width(), codes.height(), codes.channels());
  std::copy(codes.values().begin(), codes.values().end(), picture.values().begin());
  return picture;
}

}  // namespace kappamu::io
