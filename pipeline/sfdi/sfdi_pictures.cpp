#include "pipeline/sfdi/sfdi_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"
#include "io/mat_file.h"
#include "io/npy.h"

namespace kappamu::pipeline::sfdi {

namespace {

namespace fs = std::filesystem;

/// "raw.mat", "raw.mat:frames" or "raw.mat:frames:2": a page of a variable.
Image<float> read_mat(const std::string& name) {
  const std::size_t end = name.find(".mat") + 4;
  const std::string rest = name.substr(std::min(end + 1, name.size()));
  const std::size_t colon = rest.find(':');
  const std::string number = colon == std::string::npos ? "0" : rest.substr(colon + 1);
  if (number.empty() || number.size() > 6 ||
      number.find_first_not_of("0123456789") != std::string::npos) {
    throw InputError(name + ": a page is named as FILE.mat:VARIABLE:NUMBER, from 0");
  }
  return io::read_mat_picture(name.substr(0, end), rest.substr(0, colon), std::stoul(number));
}

/// PNG, TIFF, JPEG as codes, EXR and Radiance as floats, NPY [y][x], MATLAB [row][column].
Image<float> read_picture(const fs::path& file) {
  const std::string name = file.string();
  if (name.ends_with(".mat") || name.find(".mat:") != std::string::npos) return read_mat(name);
  if (file.extension() == ".npy") {
    const io::NpyArray array = io::read_npy(file);
    if (array.shape.size() != 2) {
      throw InputError(file.string() + ": array has shape " + io::shape_to_string(array.shape) +
                       "; a picture has two axes, [y][x]");
    }
    Image<float> picture(static_cast<int>(array.shape[1]), static_cast<int>(array.shape[0]), 1);
    picture.values() = array.values;
    return picture;
  }
  if (io::is_float_image(file)) return io::read_float_image(file);
  const Image<std::uint16_t> codes = io::read_code_image(file);
  Image<float> picture(codes.width(), codes.height(), codes.channels());
  std::copy(codes.values().begin(), codes.values().end(), picture.values().begin());
  return picture;
}

/// One channel of the crop.
Image<float> read_channel(const Description& d, const std::string& name) {
  const fs::path file = d.folder / name;
  const Image<float> whole = read_picture(file);
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

}  // namespace

DemodulatedSet demodulate(const Description& description, const Pictures& pictures, bool sample,
                          const calib::Demodulated* even) {
  const std::vector<std::string>& files = sample ? pictures.sample : pictures.reference;
  std::vector<Image<float>> read;
  Image<std::uint8_t> mask;
  std::optional<Image<float>> dark;
  if (pictures.dark) dark = read_channel(description, *pictures.dark);
  DemodulatedSet result;
  for (const std::string& name : files) {
    Image<float> picture = read_channel(description, name);
    if (mask.empty()) mask = Image<std::uint8_t>(picture.width(), picture.height(), 1, 1);
    const Image<float>& first = read.empty() ? picture : read.front();
    if (!picture.same_shape(first) || (dark && !dark->same_shape(first)) ||
        (even != nullptr && !even->mean.same_shape(first))) {
      throw InputError((description.folder / name).string() +
                       ": has another size than the pictures it belongs to");
    }
    for (std::size_t i = 0; i < picture.size(); ++i) {
      float& value = picture.values()[i];
      if (!std::isfinite(value) ||
          (description.largest_code && value >= *description.largest_code)) {
        result.saturated += mask.values()[i];
        mask.values()[i] = 0;
        value = 0.0F;
      } else if (dark) {
        value -= dark->values()[i];
      }
    }
    read.push_back(std::move(picture));
  }
  const std::string where = (description.folder / files.front()).string() + ": ";
  const double sigma = description.smoothing_mm.value_or(usual_smoothing_mm) / description.pixel_mm;
  try {
    if (pictures.per_mm == 0.0) {
      result.light = calib::demodulate_even(read.front(), mask);
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
