#include "pipeline/stages/hdr_file.h"

#include "core/error.h"
#include "io/image/exr.h"
#include "io/text_stream.h"

namespace kappamu::pipeline {

namespace {

constexpr const char* notes_attribute = "notes";

template <class T>
std::vector<float> plane(const Image<T>& image, std::size_t channel) {
  const auto channels = static_cast<std::size_t>(image.channels());
  std::vector<float> result(image.size() / channels);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = static_cast<float>(image.values()[i * channels + channel]);
  return result;
}

template <class T>
void set_plane(Image<T>& image, std::size_t channel, const std::vector<float>& values) {
  const auto channels = static_cast<std::size_t>(image.channels());
  for (std::size_t i = 0; i < values.size(); ++i)
    image.values()[i * channels + channel] = static_cast<T>(values[i]);
}

}  // namespace

void write_hdr(const std::filesystem::path& file, const capture::HdrImage& image,
               const std::vector<std::string>& channels, const std::vector<std::string>& notes) {
  io::ExrImage exr;
  exr.width = image.radiance.width();
  exr.height = image.radiance.height();
  for (std::size_t c = 0; c < channels.size(); ++c) {
    exr.channels[channels[c]] = plane(image.radiance, c);
    exr.channels["variance." + channels[c]] = plane(image.variance, c);
    exr.channels["flags." + channels[c]] = plane(image.flags, c);
  }
  exr.attributes["units"] = "radiance: full scales per second; variance: its square";
  exr.attributes["flags"] = "1 saturated, 2 dark, 4 missing in every frame";
  std::string lines;
  for (const std::string& note : notes) lines.append(note).append("\n");
  if (!lines.empty()) exr.attributes[notes_attribute] = lines;
  io::write_exr(file, exr);
}

std::vector<std::string> read_hdr_notes(const std::filesystem::path& file) {
  const io::ExrImage exr = io::read_exr(file);
  const auto found = exr.attributes.find(notes_attribute);
  std::vector<std::string> notes;
  if (found == exr.attributes.end()) return notes;
  std::istringstream lines = io::text_reader(found->second);
  for (std::string line; std::getline(lines, line);) notes.push_back(line);
  return notes;
}

capture::HdrImage read_hdr(const std::filesystem::path& file,
                           const std::vector<std::string>& channels) {
  const io::ExrImage exr = io::read_exr(file);
  const auto count = static_cast<int>(channels.size());
  capture::HdrImage image{Image<float>(exr.width, exr.height, count),
                          Image<float>(exr.width, exr.height, count),
                          Image<std::uint8_t>(exr.width, exr.height, count)};
  const auto named = [&](const std::string& name) -> const std::vector<float>& {
    const auto found = exr.channels.find(name);
    if (found == exr.channels.end())
      throw InputError(file.string() + ": channel " + name + " is missing; merge again",
                       {{"force"}});
    return found->second;
  };
  for (std::size_t c = 0; c < channels.size(); ++c) {
    set_plane(image.radiance, c, named(channels[c]));
    set_plane(image.variance, c, named("variance." + channels[c]));
    set_plane(image.flags, c, named("flags." + channels[c]));
  }
  return image;
}

}  // namespace kappamu::pipeline
