#include "forward/choice/model_table.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kappamu::forward {

namespace {

#include "forward/choice/measured_models.inc"

constexpr double smooth = 0.003;  // edges of an object without sharp ones

}  // namespace

std::span<const MeasuredModel> measured_models() {
  return models;
}

MeasuredRange measured_range() {
  return range;
}

double value_of(const Law& law, const ObjectFeatures& features, double tolerance) {
  const double thickness = std::clamp(features.thickness, range.thinnest, range.thickest);
  const double albedo = std::clamp(features.albedo, range.lowest_albedo, range.highest_albedo);
  const double contrast = std::clamp(features.contrast, 1.0, range.highest_contrast);
  return std::exp(
      law.constant + law.thickness * std::log(thickness) + law.absorption * std::log(1.0 - albedo) +
      law.edges * std::log(features.edges + smooth) + law.contrast * std::log(contrast) +
      law.triangles * std::log(static_cast<double>(features.triangles)) +
      law.tolerance * std::log(tolerance));
}

}  // namespace kappamu::forward
