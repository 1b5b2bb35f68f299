#include "pipeline/stages/hdr_file.h"

#include <algorithm>

#include "core/error.h"
#include "core/numbers/widest.h"
#include "io/image/plain_exr.h"
#include "io/text_stream.h"
#include "pipeline/records/fingerprint.h"

namespace kappamu::pipeline {

namespace {

constexpr const char* notes_attribute = "notes";

/// Where the file's channels are, three a channel of the image: radiance, variance, flags.
std::vector<std::string> file_channels(const std::vector<std::string>& channels) {
  std::vector<std::string> names;
  for (const std::string& channel : channels) {
    names.insert(names.end(), {channel, "variance." + channel, "flags." + channel});
  }
  return names;
}

/// Every `channels`-th value of a row. Of three channels apart: compilers load that in wide
/// registers.
template <class Value>
[[gnu::always_inline]] inline void pick_channel(const Value* from, std::size_t channels,
                                                std::size_t width, float* to) {
  if (channels == 3) {
    for (std::size_t x = 0; x < width; ++x) to[x] = static_cast<float>(from[3 * x]);
  } else {
    for (std::size_t x = 0; x < width; ++x) to[x] = static_cast<float>(from[x * channels]);
  }
}
KAPPAMU_WIDEST void pick_floats(const float* from, std::size_t channels, std::size_t width,
                                float* to) {
  pick_channel(from, channels, width, to);
}
KAPPAMU_WIDEST void pick_flags(const std::uint8_t* from, std::size_t channels, std::size_t width,
                               float* to) {
  pick_channel(from, channels, width, to);
}

}  // namespace

std::string write_hdr(const std::filesystem::path& file, const capture::HdrImage& image,
                      const capture::Session& session, const std::vector<std::string>& notes) {
  io::ExrHeader header{image.place(),
                       session.camera.width,
                       session.camera.height,
                       file_channels(session.channels),
                       {}};
  for (const std::string& channel : session.channels) header.halves.push_back("flags." + channel);
  header.attributes["units"] = "radiance: full scales per second; variance: its square";
  header.attributes["flags"] = "1 saturated, 2 dark, 4 missing in every frame";
  std::string lines;
  for (const std::string& note : notes) lines.append(note).append("\n");
  if (!lines.empty()) header.attributes[notes_attribute] = lines;
  const std::size_t channels = session.channels.size();
  const auto width = static_cast<std::size_t>(header.data.width);
  const auto fill = [&](int y, std::size_t channel, float* to) {
    const std::size_t first = static_cast<std::size_t>(y) * width * channels + channel / 3;
    if (channel % 3 == 2) return pick_flags(&image.flags.values()[first], channels, width, to);
    const Image<float>& from = channel % 3 == 0 ? image.radiance : image.variance;
    pick_floats(&from.values()[first], channels, width, to);
  };
  ContentFingerprint written;
  io::write_plain_exr(file, header, fill, [&](std::span<const char> part) { written.add(part); });
  return written.text();
}

capture::HdrImage read_hdr(const std::filesystem::path& file,
                           const std::vector<std::string>& channels,
                           std::vector<std::string>* notes) {
  capture::HdrImage image;
  const auto open = [&](const io::ExrHeader& header) -> io::TakeExrRows {
    std::vector<std::size_t> place;
    for (const std::string& name : file_channels(channels)) {
      const auto found = std::find(header.channels.begin(), header.channels.end(), name);
      if (found == header.channels.end())
        throw InputError(file.string() + ": channel " + name + " is missing; merge again",
                         {{"force"}});
      place.push_back(static_cast<std::size_t>(found - header.channels.begin()));
    }
    const io::ExrHeader& h = header;
    const auto count = static_cast<int>(channels.size());
    image = {Image<float>(h.data.width, h.data.height, count),
             Image<float>(h.data.width, h.data.height, count),
             Image<std::uint8_t>(h.data.width, h.data.height, count), h.data.left, h.data.top};
    const auto lines = h.attributes.find(notes_attribute);
    if (notes != nullptr && lines != h.attributes.end()) {
      std::istringstream text = io::text_reader(lines->second);
      for (std::string line; std::getline(text, line);) notes->push_back(line);
    }
    return [&image, place, stored = h.channels.size()](int first, int rows, const float* values) {
      const std::size_t of_pixel = place.size() / 3;
      const std::size_t row = static_cast<std::size_t>(image.radiance.width()) * of_pixel;
      std::size_t at = static_cast<std::size_t>(first) * row;
      const std::size_t end = at + static_cast<std::size_t>(rows) * row;
      for (; at < end; values += stored) {
        for (std::size_t c = 0; c < of_pixel; ++c, ++at) {
          image.radiance.values()[at] = values[place[3 * c]];
          image.variance.values()[at] = values[place[3 * c + 1]];
          image.flags.values()[at] = static_cast<std::uint8_t>(values[place[3 * c + 2]]);
        }
      }
    };
  };
  io::read_exr_rows(file, open);
  return image;
}

}  // namespace kappamu::pipeline
