// Thumbnails and statistics of the HDR images, from an even lattice of their pixels.
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/radiance/hdr.h"
#include "core/error.h"
#include "core/parallel.h"
#include "io/image/exr.h"
#include "report/drawing/picture.h"
#include "report/read/run_data.h"

namespace kappamu::report {

namespace {

constexpr int thumbnail_pixels = 160;

const std::vector<float>& channel_of(const io::ExrImage& image, const std::string& name,
                                     const std::filesystem::path& file) {
  const auto found = image.channels.find(name);
  if (found == image.channels.end())
    throw InputError(file.string() + ": channel " + name +
                     " is missing; make the file again with `kappamu merge`");
  return found->second;
}

/// The image's own channel names: those that have a variance.
std::vector<std::string> channel_names(const io::ExrImage& image) {
  std::vector<std::string> names;
  for (const char* name : {"R", "G", "B"})
    if (image.channels.contains(std::string("variance.") + name)) names.emplace_back(name);
  if (names.empty())
    for (const auto& entry : image.channels)
      if (image.channels.contains("variance." + entry.first)) names.push_back(entry.first);
  return names;
}

/// Every so many pixels along both sides that the longer one has `sampled_pixels` to twice that.
io::ExrImage sampled(const std::filesystem::path& file) {
  constexpr int sampled_pixels = 640;
  io::ExrImage sample;
  int step = 1;
  const auto open = [&](const io::ExrHeader& header) -> io::TakeExrRows {
    const int width = header.data.width, height = header.data.height;
    step = std::max(1, std::max(width, height) / sampled_pixels);
    sample.width = (width + step - 1) / step;
    sample.height = (height + step - 1) / step;
    std::vector<std::vector<float>*> planes;
    for (const std::string& name : header.channels) planes.push_back(&sample.channels[name]);
    return [planes, width, step = step](int first, int rows, const float* values) {
      for (int row = 0; row < rows; ++row) {
        if ((first + row) % step != 0) continue;
        for (int x = 0; x < width; x += step) {
          const std::size_t at = (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x)) *
                                 planes.size();
          for (std::size_t c = 0; c < planes.size(); ++c) planes[c]->push_back(values[at + c]);
        }
      }
    };
  };
  io::read_exr_rows(file, open, {}, [&](const io::ExrHeader&) { return step; });
  return sample;
}

HdrSummary summarise(const std::filesystem::path& file) {
  const io::ExrImage exr = sampled(file);
  const std::vector<std::string> names = channel_names(exr);
  HdrSummary summary;
  summary.pattern = file.stem().string();
  Image<float> radiance(exr.width, exr.height, names.size() == 3 ? 3 : 1);
  Image<float> noisiest(exr.width, exr.height, 1, -std::numeric_limits<float>::infinity());
  Image<float> saturation(exr.width, exr.height, 1);
  std::vector<float> valid;
  std::optional<double> noise;
  std::size_t saturated = 0, dark = 0, missing = 0, all = 0;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const std::vector<float>& value = channel_of(exr, names[c], file);
    const std::vector<float>& variance = channel_of(exr, "variance." + names[c], file);
    const std::vector<float>& flags = channel_of(exr, "flags." + names[c], file);
    std::vector<float> deviation;
    for (std::size_t i = 0; i < value.size(); ++i) {
      const auto flag = static_cast<unsigned>(flags[i]);
      if (c < static_cast<std::size_t>(radiance.channels()))
        radiance.values()[i * static_cast<std::size_t>(radiance.channels()) + c] = value[i];
      ++all;
      saturated += (flag & capture::pixel_saturated) != 0 ? 1 : 0;
      dark += (flag & capture::pixel_dark) != 0 ? 1 : 0;
      missing += (flag & capture::pixel_missing) != 0 ? 1 : 0;
      if ((flag & capture::pixel_saturated) != 0) {
        saturation.values()[i] += 1.0F / static_cast<float>(names.size());
      }
      noisiest.values()[i] =
          flag == capture::pixel_ok && value[i] > 0.0F && !std::isnan(noisiest.values()[i])
              ? std::max(noisiest.values()[i], std::log10(std::sqrt(variance[i]) / value[i]))
              : std::numeric_limits<float>::quiet_NaN();
      if (flag != capture::pixel_ok) continue;
      valid.push_back(value[i]);
      deviation.push_back(std::sqrt(variance[i]));
    }
    if (deviation.empty()) continue;
    const double floor = quantile(std::move(deviation), 0.01);
    noise = std::min(noise.value_or(floor), floor);
  }
  summary.thumbnail = reduced(radiance, thumbnail_pixels);
  summary.relative_noise = reduced(noisiest, thumbnail_pixels);
  summary.saturation = reduced(saturation, thumbnail_pixels);
  summary.bright = quantile(std::move(valid), 0.999);
  summary.noise = noise.value_or(0.0);
  const double count = std::max<double>(1.0, static_cast<double>(all));
  summary.saturated = static_cast<double>(saturated) / count;
  summary.dark = static_cast<double>(dark) / count;
  summary.missing = static_cast<double>(missing) / count;
  return summary;
}

}  // namespace

std::vector<HdrSummary> summarise_hdr(const std::filesystem::path& run) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(run / "hdr"))
    for (const auto& entry : std::filesystem::directory_iterator(run / "hdr"))
      if (entry.path().extension() == ".exr" &&
          entry.path().string().find(".partial-") == std::string::npos)  // left by a killed merge
        files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<HdrSummary> summaries(files.size());
  constexpr unsigned most_files = 4;  // each is held in memory as a file while it is read
  for_rows(
      static_cast<int>(files.size()),
      [&](int i) {
        summaries[static_cast<std::size_t>(i)] = summarise(files[static_cast<std::size_t>(i)]);
      },
      most_files);
  return summaries;
}

}  // namespace kappamu::report
