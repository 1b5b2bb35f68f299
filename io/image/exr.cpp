#include "io/image/exr.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <new>
#include <span>
#include <string_view>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/image/image_integrity.h"
#include "io/image/oiio_input.h"
#include "io/image/plain_exr.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail_damaged(const fs::path& file) {
  throw InputError(file.string() + ": truncated or damaged EXR file; write or copy it again");
}

void decode_exr(const fs::path& file, std::span<std::byte> bytes, const OpenExr& open,
                const SizeCheck& expected, const ChooseStep& step = {}) {
  const auto fail = [&](const std::string& why) { throw InputError(file.string() + ": " + why); };
  if (image_kind(bytes) != ImageKind::exr) fail("not an EXR file");
  OiioInput input(file, bytes);
  // OpenEXR's own texts speak of scan lines and offsets: the user's fix is the same for all.
  if (!input.opened()) fail("truncated, damaged or unusual EXR file; write or copy it again");
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.deep) fail("deep EXR, several samples a pixel; flatten it");
  if (expected) expected({spec.full_width, spec.full_height, spec.nchannels});
  check_size(file, {spec.width, spec.height, spec.nchannels}, bytes.size(),
             expected ? [](const ImageSize&) {} : SizeCheck{});
  if (spec.tile_width > 0) {
    check_size(file, {spec.tile_width, spec.tile_height, spec.nchannels}, bytes.size(), {});
  }
  ExrHeader header{{spec.x - spec.full_x, spec.y - spec.full_y, spec.width, spec.height},
                   spec.full_width,
                   spec.full_height,
                   spec.channelnames,
                   {}};
  if (intersection(header.data, {0, 0, header.width, header.height}) != header.data) {
    fail("its data window lies beyond its display window; crop it to that");
  }
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeString) {
      header.attributes[attribute.name().string()] = attribute.get_string();
    }
  }
  const TakeExrRows take = open(header);
  const auto take_rows = [&](int first, int rows, const std::byte* pixels) {
    take(first, rows, reinterpret_cast<const float*>(pixels));
  };
  const int every = step ? step(header) : 1;
  const std::size_t row_size = sizeof(float) * static_cast<std::size_t>(spec.nchannels) *
                               static_cast<std::size_t>(spec.width);
  const auto take_some = [&](int first, int rows, const std::byte* pixels) {
    for (int row = first; row < first + rows; ++row, pixels += row_size)
      if (row % every == 0) take_rows(row, 1, pixels);
  };
  const bool whole =
      every > 1 ? input.read(OIIO::TypeFloat, take_some) : input.read(OIIO::TypeFloat, take_rows);
  if (!whole) fail_damaged(file);
}

/// Whether the bytes hold what was to be written.
bool holds(const fs::path& file, std::span<std::byte> encoded, const ExrHeader& header,
           const FillExrRows& fill) {
  bool equal = true;
  std::vector<float> expected;
  std::vector<std::size_t> place;  // of the written channels in the header: OpenImageIO sorts them
  const std::size_t channels = header.channels.size();
  decode_exr(file, encoded,
             [&](const ExrHeader& written) -> TakeExrRows {
               for (const std::string& name : written.channels) {
                 const auto found = std::find(header.channels.begin(), header.channels.end(), name);
                 place.push_back(static_cast<std::size_t>(found - header.channels.begin()));
               }
               equal = written.data == header.data && place.size() == channels &&
                       std::count(place.begin(), place.end(), channels) == 0 &&
                       std::all_of(header.attributes.begin(), header.attributes.end(),
                                   [&](const auto& attribute) {
                                     const auto other = written.attributes.find(attribute.first);
                                     return other != written.attributes.end() &&
                                            other->second == attribute.second;
                                   });
               return [&](int first, int rows, const float* values) {
                 if (!equal) return;
                 expected.resize(static_cast<std::size_t>(header.data.width) *
                                 static_cast<std::size_t>(rows) * channels);
                 fill(first, rows, expected.data());
                 for (std::size_t i = 0; i < expected.size(); i += channels) {
                   for (std::size_t c = 0; c < channels; ++c) {
                     equal = equal && std::bit_cast<std::uint32_t>(values[i + c]) ==
                                          std::bit_cast<std::uint32_t>(expected[i + place[c]]);
                   }
                 }
               };
             },
             {});
  return equal;
}

}  // namespace

void read_exr_rows(const fs::path& file, const OpenExr& open, const SizeCheck& expected,
                   const ChooseStep& step) {
  if (std::optional<PlainExrFile> exr = PlainExrFile::open(file)) {
    const ExrHeader& header = exr->header();
    const ImageSize size{header.width, header.height, static_cast<int>(header.channels.size())};
    if (expected) expected(size);
    if (!expected && !step) check_size(file, size, fs::file_size(file), {});
    const TakeExrRows take = open(header);
    const int every = step ? step(header) : 1;
    std::vector<float> row(header.channels.size() * static_cast<std::size_t>(header.data.width));
    for (int y = 0; y < header.data.height; y += every) {
      if (!exr->read(y, row.data())) fail_damaged(file);
      take(y, 1, row.data());
    }
    return;
  }
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  decode_exr(file, bytes, open, expected, step);
}

ExrImage read_exr(const fs::path& file, const SizeCheck& expected) {
  ExrImage image;
  std::vector<float*> planes;
  const auto open = [&](const ExrHeader& header) -> TakeExrRows {
    if (header.data != Region{0, 0, header.width, header.height}) {
      throw InputError(file.string() +
                       ": its data window is another than its display window; write it without "
                       "cropping");
    }
    image = {header.width, header.height, {}, header.attributes};
    for (const std::string& name : header.channels) {
      std::vector<float>& values = image.channels[name];
      values.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
      planes.push_back(values.data());
    }
    return [&](int first, int rows, const float* from) {
      const auto width = static_cast<std::size_t>(image.width);
      // Row by row, while it is in the cache.
      for (std::size_t at = static_cast<std::size_t>(first) * width, row = 0;
           row < static_cast<std::size_t>(rows); ++row, at += width) {
        for (std::size_t c = 0; c < planes.size(); ++c) {
          for (std::size_t x = 0; x < width; ++x) {
            planes[c][at + x] = from[(row * width + x) * planes.size() + c];
          }
        }
      }
    };
  };
  read_exr_rows(file, open, expected);
  return image;
}

void write_exr_rows(const fs::path& file, const ExrHeader& header, const FillExrRows& fill) {
  const Region& data = header.data;
  check(data.width > 0 && data.height > 0 && !header.channels.empty(),
        "EXR image for " + file.string() + " is empty");
  OIIO::ImageSpec spec(data.width, data.height, static_cast<int>(header.channels.size()),
                       OIIO::TypeFloat);
  spec.x = data.left;
  spec.y = data.top;
  spec.full_width = header.width;
  spec.full_height = header.height;
  spec.channelnames = header.channels;
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", "");  // else the present time: equal images, equal bytes
  for (const auto& [name, text] : header.attributes) spec.attribute(name, text);
  auto bytes = encode_image(
      "openexr", spec,
      [&](int first, int rows, std::byte* pixels) {
        fill(first, rows, reinterpret_cast<float*>(pixels));
      },
      file.string());
  // Where an allocation fails, OpenEXR leaves out scan lines and attributes without a word.
  const auto encoded = std::as_writable_bytes(std::span(bytes));
  // The empty date is an attribute too, which is not read back.
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool dated = text.find("capDate") != std::string_view::npos;
  if (!dated || !holds(file, encoded, header, fill)) throw std::bad_alloc();
  write_bytes_atomically(file, encoded);
}

void write_exr(const fs::path& file, const ExrImage& image) {
  ExrHeader header{
      {0, 0, image.width, image.height}, image.width, image.height, {}, image.attributes};
  std::vector<const float*> planes;
  const auto width = static_cast<std::size_t>(image.width);
  for (const auto& [name, values] : image.channels) {
    check(values.size() == width * static_cast<std::size_t>(image.height),
          "EXR channel " + name + " does not have the image's size");
    header.channels.push_back(name);
    planes.push_back(values.data());
  }
  const auto fill = [&](int first, int rows, float* values) {
    const std::size_t begin = static_cast<std::size_t>(first) * width;
    const std::size_t pixels = static_cast<std::size_t>(rows) * width;
    for (std::size_t i = 0; i < pixels; ++i) {
      for (const float* plane : planes) *values++ = plane[begin + i];
    }
  };
  write_exr_rows(file, header, fill);
}

}  // namespace kappamu::io
