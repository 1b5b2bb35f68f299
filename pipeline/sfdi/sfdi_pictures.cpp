#include "pipeline/sfdi/sfdi_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::pipeline::sfdi {

namespace {

namespace fs = std::filesystem;

/// One channel of the crop.
Image<float> read_channel(const Description& d, const std::string& name, PictureReader& reader) {
  const fs::path file = d.folder / name;
  const Image<float> whole = reader.read(d.folder, name);
  int channel = 0;
  if (whole.channels() == 3) {
    if (d.channel.empty()) {
      throw InputError(file.string() +
                       ": is a colour picture; state its \"channel\", R, G or B, in " + file_name);
    }
    channel = d.channel == "R" ? 0 : d.channel == "G" ? 1 : 2;
  }
  const auto [x0, y0, width, height] =
      d.crop_px.value_or(std::array<int, 4>{0, 0, whole.width(), whole.height()});
  if (x0 + width > whole.width() || y0 + height > whole.height()) {
    throw InputError(file.string() + ": has " + std::to_string(whole.width()) + " x " +
                     std::to_string(whole.height()) + " pixels; crop_px in " + file_name +
                     " reaches beyond");
  }
  Image<float> picture(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) picture(x, y) = whole(x0 + x, y0 + y, channel);
  }
  return picture;
}

/// Codes from here on are saturated: as stated, or the largest that 8 to 16 bits hold where more
/// values have exactly that than noise would leave there.
std::optional<double> saturation_of(const Description& d, const Image<float>& picture) {
  if (d.largest_code) return d.largest_code;
  const auto& values = picture.values();
  const float largest = *std::max_element(values.begin(), values.end());
  constexpr std::ptrdiff_t least_values = 30;
  for (int bits = 8; bits <= 16; ++bits) {
    if (largest != static_cast<float>((1 << bits) - 1)) continue;
    if (std::count(values.begin(), values.end(), largest) >= least_values) return largest;
  }
  return std::nullopt;
}

/// Each `repeats` pictures in a row as their mean.
void average(std::vector<Image<float>>& pictures, std::size_t repeats) {
  if (repeats < 2) return;
  std::vector<Image<float>> means;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i % repeats == 0) {
      means.push_back(std::move(pictures[i]));
      for (float& value : means.back().values()) value /= static_cast<float>(repeats);
      continue;
    }
    for (std::size_t k = 0; k < means.back().size(); ++k) {
      means.back().values()[k] += pictures[i].values()[k] / static_cast<float>(repeats);
    }
  }
  pictures = std::move(means);
}

}  // namespace

DemodulatedSet demodulate(const Description& description, const Pictures& pictures, bool sample,
                          const calib::Demodulated* even, PictureReader& reader) {
  const std::vector<std::string>& files = sample ? pictures.sample : pictures.reference;
  std::vector<Image<float>> read;
  Image<std::uint8_t> mask;
  std::optional<Image<float>> dark;
  if (pictures.dark) dark = read_channel(description, *pictures.dark, reader);
  const bool taken = pictures.content == Content::light;
  DemodulatedSet result;
  for (const std::string& name : files) {
    Image<float> picture = read_channel(description, name, reader);
    if (mask.empty()) mask = Image<std::uint8_t>(picture.width(), picture.height(), 1, 1);
    const Image<float>& first = read.empty() ? picture : read.front();
    if (!picture.same_shape(first) || (dark && !dark->same_shape(first)) ||
        (even != nullptr && !even->mean.same_shape(first))) {
      throw InputError((description.folder / name).string() +
                       ": has another size than the pictures it belongs to");
    }
    const std::optional<double> saturated_from =
        taken ? saturation_of(description, picture) : description.largest_code;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      float& value = picture.values()[i];
      if (!std::isfinite(value) || (saturated_from && value >= *saturated_from)) {
        result.saturated += mask.values()[i];
        mask.values()[i] = 0;
        value = 0.0F;
      } else if (dark) {
        value -= dark->values()[i];
      }
    }
    read.push_back(std::move(picture));
  }
  const bool even_light = pictures.per_mm == 0.0;
  average(read, even_light ? read.size() : static_cast<std::size_t>(pictures.repeats.value_or(1)));
  const std::string where = (description.folder / files.front()).string() + ": ";
  const double sigma = description.smoothing_mm.value_or(usual_smoothing_mm) / description.pixel_mm;
  try {
    if (even_light || !taken) {
      result.light = calib::demodulate_even(read.front(), mask);
      if (!even_light) {  // nothing is known of the mean
        std::swap(result.light.mean, result.light.amplitude);
        std::swap(result.light.mean_deviation, result.light.amplitude_deviation);
      }
      calib::smooth(result.light, sigma);
    } else if (read.size() == 1) {
      const double direction = pictures.direction_degrees.value_or(0.0) * std::numbers::pi / 180.0;
      const double per_pixel = pictures.per_mm * description.pixel_mm;
      const calib::Carrier carrier = calib::find_carrier(
          read.front(), mask, {per_pixel * std::cos(direction), per_pixel * std::sin(direction)});
      result.found_per_mm = carrier.frequency() / description.pixel_mm;
      if (even != nullptr) {
        for (std::size_t i = 0; i < mask.size(); ++i) {
          mask.values()[i] = mask.values()[i] & even->mask.values()[i];
        }
      }
      result.light = calib::demodulate_single(
          read.front(), even != nullptr ? even->mean : Image<float>(), mask, carrier);
    } else {
      std::vector<double> phases = pictures.phases_degrees;
      for (double& phase : phases) phase *= std::numbers::pi / 180.0;
      for (std::size_t i = 0; phases.size() < read.size(); ++i) {
        phases.push_back(2.0 * std::numbers::pi * static_cast<double>(i) /
                         static_cast<double>(read.size()));
      }
      result.light = calib::demodulate_phases(read, phases, mask);
      calib::smooth(result.light, sigma);
    }
  } catch (const InputError& error) {
    throw InputError(where + error.what());
  }
  return result;
}

}  // namespace kappamu::pipeline::sfdi
