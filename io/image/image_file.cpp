#include "io/image/image_file.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "io/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/image_integrity.h"
#include "io/image/oiio_input.h"
#include "io/image/png_writer.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

template <class Code>
OIIO::ImageSpec spec_of(const Image<Code>& image) {
  check(!image.empty() && (image.channels() == 1 || image.channels() == 3),
        "only images of one or three channels can be written");
  return {image.width(), image.height(), image.channels(), OIIO::BaseTypeFromC<Code>::value};
}

template <class Code>
PngPixels png_pixels(const Image<Code>& image) {
  const OIIO::ImageSpec spec = spec_of(image);
  return {image.values().data(), spec.width, spec.height, spec.nchannels,
          static_cast<int>(8 * sizeof(Code))};
}

/// For camera frames: noise hardly compresses, and looking for runs only is a third faster than
/// zlib's default search and gives smaller files (measured on 16-bit frames with shot noise).
template <class Code>
std::vector<unsigned char> encode_frame_png(const Image<Code>& image) {
  return write_png(png_pixels(image), PngEffort::fast);
}

template <class Code>
std::vector<unsigned char> encode_tiff(const Image<Code>& image, const std::string& what) {
  OIIO::ImageSpec spec = spec_of(image);
  spec.attribute("compression", "lzw");
  spec.attribute("DateTime", "");  // else the present time: equal frames, equal bytes
  return encode_image("tiff", spec, image.values().data(), what);
}

template <class Code>
void write_by_extension(const fs::path& file, const Image<Code>& image) {
  const std::string extension = lower_extension(file);
  if (extension != ".png" && extension != ".tif" && extension != ".tiff") {
    throw InputError("cannot write " + file.string() +
                     ": images are written as .png, .tif or .tiff, choose one of these endings");
  }
  const auto bytes =
      extension == ".png" ? encode_frame_png(image) : encode_tiff(image, file.string());
  write_bytes_atomically(file, std::as_bytes(std::span(bytes)));
}

/// Codes of `pixels` pixels with `stored` channels each, of which `to` keeps the first ones.
template <class Code>
void copy_codes(const std::byte* from, std::size_t pixels, std::size_t stored, std::size_t kept,
                std::uint16_t* to) {
  const auto* codes = reinterpret_cast<const Code*>(from);
  if (stored == kept) {
    std::copy_n(codes, pixels * kept, to);
    return;
  }
  for (std::size_t i = 0; i < pixels; ++i) std::copy_n(codes + i * stored, kept, to + i * kept);
}

struct Codes {
  Image<std::uint16_t> image;
  int bits = 8;  ///< of each code in the file, 8 or 16
};

/// Goes to the picture's page among previews and masks (NewSubfileType, TIFF 6.0, section 8).
void select_page(OiioInput& input, const fs::path& file) {
  constexpr int reduced = 1, mask = 4;
  std::vector<int> full;
  int pages = 0;
  for (; input.select(pages); ++pages) {
    const int type = input.spec().get_int_attribute("tiff:subfiletype", 0);
    if ((type & (reduced | mask)) == 0) full.push_back(pages);
  }
  if (full.size() > 1) {
    throw InputError(file.string() + ": holds " + std::to_string(full.size()) +
                     " full pictures (pages); save the one that is meant as a file of its own");
  }
  if (full.empty() && pages > 1) {
    throw InputError(file.string() + ": holds previews and masks only; save the full picture");
  }
  input.select(full.empty() ? 0 : full.front());
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
  throw InputError(file.string() + ": holds " + what + "; save it as grey, black as 0, or RGB");
}

Codes read_codes(const fs::path& file, const SizeCheck& expected,
                 const std::optional<Region>& part) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  const ImageKind kind = image_kind(bytes);
  const auto fail = [&](const std::string& why) { throw InputError(file.string() + ": " + why); };
  if (bytes.empty()) fail("the file is empty");
  if (kind == ImageKind::unknown) fail("not a PNG, TIFF or JPEG image");
  const std::string name = to_string(kind);
  if (kind == ImageKind::exr || kind == ImageKind::radiance) {
    fail("not a PNG, TIFF or JPEG image but " + name + "; give it that format's ending");
  }
  const Integrity integrity = check_integrity(bytes);
  if (integrity != Integrity::complete) {
    fail((integrity == Integrity::truncated ? "truncated " : "damaged ") + name +
         " image; copy or photograph it again");
  }
  if (const auto size = jpeg_size(bytes)) check_size(file, *size, bytes.size(), expected);
  OiioInput input(file, bytes);
  if (!input.opened()) fail("truncated or damaged " + name + " image; copy or photograph it again");
  if (kind == ImageKind::tiff) select_page(input, file);
  check_colours(input.spec(), file);
  const OIIO::ImageSpec& spec = input.spec();
  const bool has_alpha = spec.nchannels > 1 && spec.alpha_channel == spec.nchannels - 1;
  const int channels = spec.nchannels - (has_alpha ? 1 : 0);
  const int bits = spec.get_int_attribute("oiio:BitsPerSample", 8);
  if ((channels != 1 && channels != 3) || (bits != 8 && bits != 16) || spec.depth != 1 ||
      (spec.format != OIIO::TypeUInt8 && spec.format != OIIO::TypeUInt16) ||
      spec.get_string_attribute("planarconfig") == "separate") {
    fail("unreadable " + name +
         " image; it must be grey or interleaved RGB with 8 or 16 bits per channel");
  }
  check_size(file, {spec.width, spec.height, channels}, bytes.size(), expected);
  if (spec.tile_width > 0) {
    check_size(file, {spec.tile_width, spec.tile_height, channels}, bytes.size(), {});
  }
  const Region kept = part.value_or(Region{0, 0, spec.width, spec.height});
  Image<std::uint16_t> image(kept.width, kept.height, channels);
  const auto copy =
      spec.format == OIIO::TypeUInt8 ? copy_codes<std::uint8_t> : copy_codes<std::uint16_t>;
  const std::size_t pixel_bytes = static_cast<std::size_t>(spec.nchannels) * spec.format.size();
  const auto take = [&](int first, int rows, const std::byte* pixels) {
    for (int row = std::max(first, kept.top); row < std::min(first + rows, kept.bottom()); ++row) {
      const std::size_t at =
          static_cast<std::size_t>(row - first) * static_cast<std::size_t>(spec.width) +
          static_cast<std::size_t>(kept.left);
      copy(pixels + at * pixel_bytes, static_cast<std::size_t>(kept.width),
           static_cast<std::size_t>(spec.nchannels), static_cast<std::size_t>(channels),
           &image(0, row - kept.top));
    }
  };
  const bool whole = input.read(spec.format, take, kept.bottom());
  if (!whole) fail("truncated or damaged " + name + " image; copy or photograph it again");
  return {std::move(image), spec.format == OIIO::TypeUInt8 ? 8 : 16};
}

}  // namespace

Image<std::uint16_t> read_code_image(const fs::path& file, const SizeCheck& expected,
                                     const std::optional<Region>& part) {
  return read_codes(file, expected, part).image;
}

Image<float> read_relative_image(const fs::path& file) {
  const Codes codes = read_codes(file, {}, std::nullopt);
  const float white = codes.bits == 16 ? 65535.0F : 255.0F;
  Image<float> image(codes.image.width(), codes.image.height(), codes.image.channels());
  std::transform(codes.image.values().begin(), codes.image.values().end(), image.values().begin(),
                 [&](std::uint16_t code) { return static_cast<float>(code) / white; });
  return image;
}

void write_image(const fs::path& file, const Image<std::uint8_t>& image) {
  write_by_extension(file, image);
}
void write_image(const fs::path& file, const Image<std::uint16_t>& image) {
  write_by_extension(file, image);
}

void write_float_image(const fs::path& file, const Image<float>& image) {
  check(image.channels() == 1 || image.channels() == 3, "float images have one or three channels");
  ExrImage exr{image.width(), image.height(), {}, {}};
  const std::vector<std::string> names = image.channels() == 1
                                             ? std::vector<std::string>{"Y"}
                                             : std::vector<std::string>{"R", "G", "B"};
  for (std::size_t c = 0; c < names.size(); ++c) {
    std::vector<float>& plane = exr.channels[names[c]];
    plane.resize(image.size() / names.size());
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = image.values()[i * names.size() + c];
  }
  write_exr(file, exr);
}

void write_code_image(const fs::path& file, const Image<std::uint16_t>& image, int bit_depth) {
  check(bit_depth >= 8 && bit_depth <= 16, "camera codes have 8 to 16 bits");
  const auto& codes = image.values();
  check(std::all_of(codes.begin(), codes.end(), [&](int code) { return code >> bit_depth == 0; }),
        "camera code above 2^" + std::to_string(bit_depth) + " - 1 for " + file.string());
  if (bit_depth > 8) return write_image(file, image);
  Image<std::uint8_t> narrow(image.width(), image.height(), image.channels());
  std::transform(codes.begin(), codes.end(), narrow.values().begin(),
                 [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
  write_image(file, narrow);
}

std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image) {
  return write_png(png_pixels(image), PngEffort::small);
}

std::vector<std::uint8_t> encode_jpeg(const Image<std::uint8_t>& image, int quality) {
  OIIO::ImageSpec spec = spec_of(image);
  spec.attribute("Compression", "jpeg:" + std::to_string(quality));
  return encode_image("jpeg", spec, image.values().data(), "a picture");
}

}  // namespace kappamu::io
