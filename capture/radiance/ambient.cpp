#include "capture/radiance/ambient.h"

#include <algorithm>

#include "core/error.h"

namespace kappamu::capture {
namespace {

constexpr std::uint8_t unusable = pixel_saturated | pixel_missing;

}  // namespace

void take_off(const HdrImage& off, HdrImage& picture) {
  check(off.place() == picture.place(),
        "pictures with the projector on and off show one part of the camera's");
  for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
    picture.radiance.values()[i] -= off.radiance.values()[i];
    picture.variance.values()[i] += off.variance.values()[i];
    picture.flags.values()[i] |= off.flags.values()[i] & unusable;
  }
}

double total_light(const HdrImage& picture) {
  double sum = 0.0;
  for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
    if ((picture.flags.values()[i] & unusable) == 0) sum += picture.radiance.values()[i];
  }
  return sum;
}

std::optional<AmbientLight> merge_ambient(const Session& session, const Radiometry& radiometry,
                                          const MergeOptions& options,
                                          std::vector<std::string>* notes) {
  const std::vector<Stack>& times = session.calibration.ambient;
  if (times.empty()) return std::nullopt;
  MergeOptions dark = options;
  dark.require_light = false;
  std::vector<HdrImage> pictures;
  for (std::size_t i = 0; i < times.size(); ++i) {
    pictures.push_back(
        merge_stack(session, times[i], "ambient " + std::to_string(i), radiometry, dark, notes));
  }
  std::sort(pictures.begin(), pictures.end(),
            [](const HdrImage& a, const HdrImage& b) { return total_light(a) < total_light(b); });
  const HdrImage& darkest = pictures.front();
  const HdrImage& brightest = pictures.back();
  AmbientLight light;
  light.mean = darkest;
  light.half_range = 0.5 * (total_light(brightest) - total_light(darkest));
  const auto count = static_cast<float>(pictures.size());
  for (std::size_t i = 0; i < darkest.radiance.size(); ++i) {
    float sum = 0.0F;
    float variance = 0.0F;
    for (const HdrImage& picture : pictures) {
      sum += picture.radiance.values()[i];
      variance += picture.variance.values()[i];
      light.mean.flags.values()[i] |= picture.flags.values()[i];
    }
    light.mean.radiance.values()[i] = sum / count;
    light.mean.variance.values()[i] = variance / (count * count);
  }
  // One factor for the whole picture: pixel by pixel the range would be noise.
  light.total = total_light(light.mean);
  const double relative = light.total > 0.0 ? light.half_range / light.total : 0.0;
  for (std::size_t i = 0; i < darkest.radiance.size(); ++i) {
    const double change = relative * light.mean.radiance.values()[i];
    light.mean.variance.values()[i] += static_cast<float>(change * change);
  }
  return light;
}

}  // namespace kappamu::capture
