#include "forward/choice/model_table.h"

#include <algorithm>
#include <cmath>

namespace kappamu::forward {

namespace {

#include "forward/choice/measured_models.inc"

constexpr double slant_of_sphere = 1.0 / 3.0;
constexpr double deep = 3.0;  // studies/fit_choice.py

}  // namespace

const MeasuredModel& measured(std::string_view name) {
  return *std::find_if(models.begin(), models.end(),
                       [&](const MeasuredModel& model) { return model.name == name; });
}

MeasuredRange measured_range() {
  return range;
}

double error_by(const ErrorLaw& law, const ObjectFeatures& features) {
  const double thickness = std::min(features.thickness, range.thickest);
  const double absorbed = 1.0 - std::min(features.albedo, range.highest_albedo);
  const double of_absorption = law.absorbed * absorbed * thickness / (thickness + deep);
  const double others = law.constant + law.inverse_thickness / thickness +
                        law.inverse_root_thickness / std::sqrt(thickness) +
                        law.root_absorbed * std::sqrt(absorbed) + law.edges * features.edges +
                        law.inverse_size / features.size;
  const double slant = std::min(features.slant, range.most_slant) - slant_of_sphere;
  return (others * std::exp(law.diffuse * features.diffuse) +
          of_absorption *
              std::pow(std::exp(law.absorbed_diffuse) * std::sqrt(absorbed), features.diffuse)) *
         std::exp(law.slant * (1.0 - features.diffuse) * slant);
}

double seconds_by(const CostLaw& law, const ObjectFeatures& features, double tolerance) {
  const double thickness = std::clamp(features.thickness, range.thinnest, range.thickest);
  const double albedo = std::clamp(features.albedo, range.lowest_albedo, range.highest_albedo);
  const double contrast = std::clamp(features.contrast, 1.0, range.highest_contrast);
  return std::exp(law.constant + law.thickness * std::log(thickness) +
                  law.absorbed * std::log(1.0 - albedo) + law.contrast * std::log(contrast) +
                  law.triangles * std::log(static_cast<double>(features.triangles)) +
                  law.tolerance * std::log(tolerance));
}

}  // namespace kappamu::forward
