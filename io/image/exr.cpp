#include "io/image/exr.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <span>
#include <string_view>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/image/image_integrity.h"
#include "io/image/oiio_input.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

ExrImage decode_exr(const fs::path& file, std::vector<std::byte>& bytes,
                    const SizeCheck& expected) {
  const auto fail = [&](const std::string& why) { throw InputError(file.string() + ": " + why); };
  if (image_kind(bytes) != ImageKind::exr) fail("not an EXR file");
  OiioInput input(file, bytes);
  // OpenEXR's own texts speak of scan lines and offsets: the user's fix is the same for all.
  if (!input.opened()) fail("truncated, damaged or unusual EXR file; write or copy it again");
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.deep) fail("deep EXR, several samples a pixel; flatten it");
  check_size(file, {spec.width, spec.height, spec.nchannels}, bytes.size(), expected);
  if (spec.tile_width > 0) {
    check_size(file, {spec.tile_width, spec.tile_height, spec.nchannels}, bytes.size(), {});
  }
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height) {
    fail("its data window is another than its display window; write it without cropping");
  }
  ExrImage image{spec.width, spec.height, {}, {}};
  std::vector<float*> planes;
  for (const std::string& name : spec.channelnames) {
    std::vector<float>& values = image.channels[name];
    values.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    planes.push_back(values.data());
  }
  const bool whole = input.read(OIIO::TypeFloat, [&](int first, int rows, const std::byte* pixels) {
    const auto* from = reinterpret_cast<const float*>(pixels);
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
  });
  if (!whole) fail("truncated or damaged EXR file; write or copy it again");
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeString) {
      image.attributes[attribute.name().string()] = attribute.get_string();
    }
  }
  return image;
}

bool equal_bits(const ExrImage& written, const ExrImage& image) {
  if (written.width != image.width || written.height != image.height ||
      written.channels.size() != image.channels.size()) {
    return false;
  }
  for (const auto& [name, values] : image.channels) {
    const auto other = written.channels.find(name);
    if (other == written.channels.end() ||
        std::memcmp(other->second.data(), values.data(), values.size() * sizeof(float)) != 0) {
      return false;
    }
  }
  return std::all_of(image.attributes.begin(), image.attributes.end(), [&](const auto& attribute) {
    const auto other = written.attributes.find(attribute.first);
    return other != written.attributes.end() && other->second == attribute.second;
  });
}

}  // namespace

ExrImage read_exr(const fs::path& file, const SizeCheck& expected) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  return decode_exr(file, bytes, expected);
}

void write_exr(const fs::path& file, const ExrImage& image) {
  check(image.width > 0 && image.height > 0 && !image.channels.empty(),
        "EXR image for " + file.string() + " is empty");
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                       OIIO::TypeFloat);
  spec.channelnames.clear();
  std::vector<float> interleaved(pixels * image.channels.size());
  std::size_t c = 0;
  for (const auto& [name, values] : image.channels) {
    check(values.size() == pixels, "EXR channel " + name + " does not have the image's size");
    spec.channelnames.push_back(name);
    for (std::size_t i = 0; i < pixels; ++i) {
      interleaved[i * image.channels.size() + c] = values[i];
    }
    ++c;
  }
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", "");  // else the present time: equal images, equal bytes
  for (const auto& [name, text] : image.attributes) spec.attribute(name, text);
  const auto bytes = encode_image("openexr", spec, interleaved.data(), file.string());
  // Where an allocation fails, OpenEXR leaves out scan lines and attributes without a word.
  const auto encoded = std::as_bytes(std::span(bytes));
  std::vector<std::byte> copy(encoded.begin(), encoded.end());
  // The empty date is an attribute too, which is not read back.
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool dated = text.find("capDate") != std::string_view::npos;
  if (!dated || !equal_bits(decode_exr(file, copy, {}), image)) throw std::bad_alloc();
  write_bytes_atomically(file, encoded);
}

}  // namespace kappamu::io
