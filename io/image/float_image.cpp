// Light from EXR, Radiance and TIFF pictures of others. Declared in image_file.h.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"
#include "io/image/image_integrity.h"
#include "io/image/oiio_input.h"
#include "io/image/orientation.h"
#include "io/image/picture_values.h"
#include "io/read_file.h"
#include "io/text_stream.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why);
}

std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return small;
}

/// Channels of an EXR that together hold light.
struct Light {
  int part = 0;
  std::string name;           ///< of the layer, else of the part; empty if there is neither
  std::vector<int> channels;  ///< R, G, B or grey
  bool deep = false;
};

/// What the parts of an EXR hold.
struct Contents {
  std::vector<Light> colours, greys;
  std::vector<std::string> channels;  ///< all, by their full names
  bool chroma = false;                ///< beside luminance
};

/// 0, 1, 2 for R, G, B; 3 for grey; 4 for a chroma; 5 for the X of a vector, whose Y is no grey; -1
/// for what is no light.
int meaning_of(const std::string& name) {
  static const std::map<std::string, int> meanings{
      {"r", 0},  {"red", 0},       {"g", 1},         {"green", 1}, {"b", 2},    {"blue", 2},
      {"y", 3},  {"l", 3},         {"luminance", 3}, {"grey", 3},  {"gray", 3}, {"ry", 4},
      {"by", 4}, {"intensity", 3}, {"radiance", 3},  {"x", 5}};
  const auto found = meanings.find(lower(name));
  return found == meanings.end() ? -1 : found->second;
}

/// `part_name` is empty where there is one part only.
void add_part(const OIIO::ImageSpec& spec, int part, const std::string& part_name,
              Contents& contents) {
  std::map<std::string, std::map<int, int>> layers;  // channel by meaning
  for (int c = 0; c < spec.nchannels; ++c) {
    const std::string& full = spec.channelnames[static_cast<std::size_t>(c)];
    const std::size_t dot = full.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : full.substr(0, dot);
    const int meaning = meaning_of(dot == std::string::npos ? full : full.substr(dot + 1));
    if (meaning >= 0) layers[layer].emplace(meaning, c);
    contents.channels.push_back(part_name.empty() ? full : part_name + ":" + full);
  }
  for (const auto& [layer, found] : layers) {
    const std::string& name = layer.empty() ? part_name : layer;
    if (found.count(4) > 0) {
      contents.chroma = true;
    } else if (found.count(0) > 0 && found.count(1) > 0 && found.count(2) > 0) {
      contents.colours.push_back({part, name, {found.at(0), found.at(1), found.at(2)}, spec.deep});
    } else if (found.count(3) > 0 && found.count(5) == 0) {
      contents.greys.push_back({part, name, {found.at(3)}, spec.deep});
    }
  }
}

/// Whether a layer or part of that name is the whole picture rather than a share of its light.
bool is_main(const std::string& name) {
  const std::string last = lower(name.substr(name.rfind('.') + 1));
  return last.empty() || last == "rgb" || last == "rgba" || last == "beauty" || last == "combined";
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return shown_text(text, 200);
}

Light light_of(OiioInput& input, const fs::path& file) {
  Contents contents;
  const bool several = input.select(1);
  for (int part = 0; input.select(part); ++part) {
    const std::string name(input.spec().get_string_attribute("oiio:subimagename"));
    add_part(input.spec(), part, several ? name : "", contents);
  }
  std::vector<Light> lights = contents.colours.empty() ? contents.greys : contents.colours;
  if (lights.empty() && contents.chroma) {
    refuse(file, "luminance/chroma EXR (Y, RY, BY); convert it to channels R, G, B");
  }
  if (lights.empty()) {
    refuse(file, "no part or layer holds R, G, B, or grey as Y; the channels are " +
                     listed(contents.channels));
  }
  if (lights.size() > 1) {
    std::vector<std::string> names;
    for (const Light& light : lights) names.push_back("'" + light.name + "'");
    std::erase_if(lights, [](const Light& light) { return !is_main(light.name); });
    if (lights.size() != 1) {
      refuse(file, "several parts or layers hold light (" + listed(names) +
                       "); save the one that is meant as a file of its own");
    }
  }
  if (lights.front().deep) refuse(file, "deep EXR, several samples a pixel; flatten it");
  return lights.front();
}

/// Refuses R, G, B whose primaries and white, as x and y each, are far from those of sRGB.
/// Radiance's own, with white at (1/3, 1/3), are near; those of Display P3 and ACES are not.
void require_srgb_primaries(const fs::path& file, std::span<const float> found) {
  constexpr std::array<float, 8> srgb{0.64F, 0.33F, 0.3F, 0.6F, 0.15F, 0.06F, 0.3127F, 0.329F};
  constexpr float near = 0.025F;
  for (std::size_t i = 0; i < srgb.size(); ++i) {
    if (found.size() == srgb.size() && std::abs(found[i] - srgb[i]) <= near) continue;
    refuse(file,
           "its R, G, B have other primaries than those of sRGB; convert it to linear sRGB "
           "(Rec. 709)");
  }
}

/// Why OpenImageIO does not open an EXR.
std::string refusal(const OiioInput& input) {
  if (input.error().find("ubsampled") != std::string::npos) {
    return "EXR with subsampled channels, such as luminance/chroma (Y, RY, BY); convert it to "
           "channels R, G, B of full size";
  }
  // OpenEXR's own texts speak of scan lines and offsets: the user's fix is the same for all.
  return "truncated, damaged or unusual EXR file; write or copy it again";
}

Image<float> read_exr_light(const fs::path& file, std::vector<std::byte>& bytes,
                            const SizeCheck& expected, Primaries wanted) {
  OiioInput input(file, bytes);
  if (!input.opened()) refuse(file, refusal(input));
  const Light light = light_of(input, file);
  input.select(light.part);
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.get_string_attribute("textureformat") == "CubeFace Environment") {
    refuse(file, "a cube map; convert it to a latitude-longitude picture");
  }
  const auto channels = static_cast<int>(light.channels.size());
  std::array<float, 8> primaries{};
  if (wanted == Primaries::srgb && channels == 3 &&
      spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8),
                        primaries.data())) {
    require_srgb_primaries(file, primaries);
  }
  for (const int channel : light.channels) {
    if (!spec.channelformat(channel).is_floating_point()) {
      refuse(file, "its channels hold whole numbers (UINT); write them as HALF or FLOAT");
    }
  }
  // The display window may be large and hold little.
  check_size(file, {spec.full_width, spec.full_height, channels},
             std::numeric_limits<std::size_t>::max(), expected);
  check_size(file, {spec.width, spec.height, spec.nchannels}, bytes.size(), [](const auto&) {});
  if (spec.tile_width > 0) {
    check_size(file, {spec.tile_width, spec.tile_height, spec.nchannels}, bytes.size(), {});
  }
  const int left = spec.x - spec.full_x, top = spec.y - spec.full_y;
  Image<float> image(spec.full_width, spec.full_height, channels);
  const int begin = std::max(left, 0), end = std::min(left + spec.width, image.width());
  if (begin >= end || top >= image.height() || top + spec.height <= 0) {
    refuse(file, "its data window lies outside its display window; write it again");
  }
  const auto pitch = static_cast<std::size_t>(spec.nchannels);
  const bool whole = input.read(OIIO::TypeFloat, [&](int first, int rows, const std::byte* pixels) {
    const auto* row = reinterpret_cast<const float*>(pixels);
    for (int y = top + first; y < top + first + rows; ++y) {
      for (int x = begin; y >= 0 && y < image.height() && x < end; ++x) {
        const float* from = row + static_cast<std::size_t>(x - left) * pitch;
        for (int c = 0; c < channels; ++c) {
          image(x, y, c) = from[light.channels[static_cast<std::size_t>(c)]];
        }
      }
      row += static_cast<std::size_t>(spec.width) * pitch;
    }
  });
  if (!whole) refuse(file, "truncated or damaged EXR file; write or copy it again");
  return image;
}

/// By what the header's lines say that the radiance was multiplied, R, G, B (Radiance file formats:
/// EXPOSURE and COLORCORR, each the product of all its lines).
std::array<double, 3> radiance_factors(const fs::path& file, std::string_view header,
                                       Primaries wanted) {
  std::array<double, 3> factors{1.0, 1.0, 1.0};
  std::istringstream lines = text_reader(std::string(header));
  for (std::string line; std::getline(lines, line);) {
    const std::string_view text = line;
    if (text.starts_with("FORMAT=") && text.find("32-bit_rle_rgbe") == std::string_view::npos) {
      refuse(file, "a Radiance picture of other than 32-bit_rle_rgbe; convert it to R, G, B");
    }
    if (wanted == Primaries::srgb && text.starts_with("PRIMARIES=")) {
      std::istringstream numbers = text_reader(line.substr(line.find('=') + 1));
      std::vector<float> primaries;
      for (float number; numbers >> number;) primaries.push_back(number);
      require_srgb_primaries(file, primaries);
    }
    const bool exposure = text.starts_with("EXPOSURE=");
    if (!exposure && !text.starts_with("COLORCORR=")) continue;
    std::istringstream numbers = text_reader(line.substr(line.find('=') + 1));
    double factor = 1.0;
    for (std::size_t c = 0; c < 3; ++c) {
      if (c == 0 || !exposure) numbers >> factor;
      if (numbers.fail() || !(factor > 0.0) || !std::isfinite(factor)) {
        refuse(file, "the header's line '" + shown_text(line, 80) + "' holds no positive number");
      }
      factors[c] *= factor;
    }
  }
  return factors;
}

Image<float> read_radiance_light(const fs::path& file, std::vector<std::byte>& bytes,
                                 const SizeCheck& expected, Primaries wanted) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::array<double, 3> factors =
      radiance_factors(file, text.substr(0, std::min(text.find("\n\n"), text.size())), wanted);
  OiioInput input(file, bytes);
  if (!input.opened())
    refuse(file, "truncated, damaged or unusual Radiance picture; write or copy it again");
  const OIIO::ImageSpec& spec = input.spec();
  check(spec.nchannels == 3, "OpenImageIO gives a Radiance picture three channels");
  check_size(file, {spec.width, spec.height, 3}, bytes.size(), expected);
  Image<float> image(spec.width, spec.height, 3);
  const bool whole = input.read(OIIO::TypeFloat, [&](int first, int rows, const std::byte* pixels) {
    const auto count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(spec.width) * 3;
    const auto* from = reinterpret_cast<const float*>(pixels);
    float* to = &image(0, first);
    for (std::size_t i = 0; i < count; ++i) {
      to[i] = static_cast<float>(from[i] / factors[i % 3]);
    }
  });
  if (!whole)
    refuse(file, "truncated, damaged or unusual Radiance picture; write or copy it again");
  const int orientation = spec.get_int_attribute("Orientation", 1);
  if (swaps_sides(orientation)) {
    refuse(file, "a Radiance picture stored column by column; write it row by row (-Y, +X)");
  }
  return turned(image, orientation);
}

}  // namespace

bool is_float_image(const fs::path& file) {
  const std::string ending = lower_extension(file);
  if (ending != ".tif" && ending != ".tiff") return ending == ".exr" || ending == ".hdr";
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && is_float_tiff(read_bytes(file, largest_image_file));
}

Image<float> read_float_image(const fs::path& file, const SizeCheck& expected,
                              Primaries primaries) {
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  switch (image_kind(bytes)) {
    case ImageKind::exr:
      return read_exr_light(file, bytes, expected, primaries);
    case ImageKind::radiance:
      return read_radiance_light(file, bytes, expected, primaries);
    case ImageKind::tiff:
      return read_tiff_floats(file, bytes, expected);
    default:
      refuse(file, "not an EXR file, nor a Radiance picture, nor a TIFF of floats");
  }
}

}  // namespace kappamu::io
