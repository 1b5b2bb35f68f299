#include "pipeline/sfdi/calibration.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::pipeline::sfdi {

namespace {

using inverse::LateralCoefficients;
using inverse::PerFrequency;

/// Linear between the wavelengths; throws InputError outside them.
PhantomRow row_at(std::vector<PhantomRow> rows, double wavelength_nm, const std::string& file,
                  const char* field) {
  std::sort(rows.begin(), rows.end(), [](const PhantomRow& a, const PhantomRow& b) {
    return a.wavelength_nm < b.wavelength_nm;
  });
  const auto above = std::find_if(rows.begin(), rows.end(), [&](const PhantomRow& row) {
    return row.wavelength_nm >= wavelength_nm;
  });
  if (above != rows.end() && above->wavelength_nm == wavelength_nm) return *above;
  if (above == rows.begin() || above == rows.end()) {
    throw InputError(file + ": " + field + ".coefficients reach from " +
                     shown_number(rows.front().wavelength_nm) + " to " +
                     shown_number(rows.back().wavelength_nm) + " nm; add " +
                     shown_number(wavelength_nm) + " nm");
  }
  const PhantomRow& low = *(above - 1);
  const double part =
      (wavelength_nm - low.wavelength_nm) / (above->wavelength_nm - low.wavelength_nm);
  const auto between = [&](double a, double b) { return a + part * (b - a); };
  PhantomRow row{wavelength_nm,
                 between(low.absorption_per_mm, above->absorption_per_mm),
                 between(low.reduced_scattering_per_mm, above->reduced_scattering_per_mm),
                 {}};
  const std::array<double, 2> none{};
  const auto a = low.relative_deviation.value_or(none),
             b = above->relative_deviation.value_or(none);
  row.relative_deviation = {std::max(a[0], b[0]), std::max(a[1], b[1])};
  return row;
}

/// `value` one deviation up, or down where the table ends.
double shifted_by(double value, double deviation, double largest) {
  return value + deviation <= largest ? value + deviation : value - deviation;
}

}  // namespace

namespace {

forward::LateralMedium lateral(const Medium& medium, double wavelength_nm, const std::string& file,
                               std::array<double, 2>& layer_deviation) {
  forward::LateralMedium result{medium.refractive_index, medium.anisotropy, medium.thickness_mm,
                                medium.slide_index};
  const auto known = [&](const Layer& layer, const char* field) {
    const PhantomRow row = row_at(layer.coefficients, wavelength_nm, file, field);
    layer_deviation = row.relative_deviation.value_or(std::array<double, 2>{});
    return forward::LateralLayer{row.absorption_per_mm, row.reduced_scattering_per_mm};
  };
  if (medium.cover) {
    result.cover =
        forward::LateralCover{known(*medium.cover, "medium.cover"), *medium.cover->thickness_mm};
  }
  if (medium.base) result.base = known(*medium.base, "medium.base");
  return result;
}

}  // namespace

Models::Models(const Medium& medium, double wavelength_nm, const std::string& file)
    : stated(forward::LateralMedium{}) {
  std::array<double, 2> layer_deviation{};
  const forward::LateralMedium as_stated = lateral(medium, wavelength_nm, file, layer_deviation);
  stated = forward::LateralReflectance(as_stated);
  if (medium.refractive_index_deviation) {
    forward::LateralMedium other = as_stated;
    other.index = shifted_by(other.index, *medium.refractive_index_deviation, 1.5);
    shifted.emplace_back(other);
  }
  if (medium.anisotropy_deviation) {
    forward::LateralMedium other = as_stated;
    other.anisotropy = shifted_by(other.anisotropy, *medium.anisotropy_deviation, 0.95);
    shifted.emplace_back(other);
  }
  for (const int which : {0, 1}) {
    const double deviation = layer_deviation[static_cast<std::size_t>(which)];
    if (deviation <= 0.0) continue;
    forward::LateralMedium other = as_stated;
    const auto shift = [&](forward::LateralLayer& layer) {
      (which == 0 ? layer.mua : layer.musp) *= 1.0 + deviation;
    };
    if (other.cover) shift(*other.cover);
    if (other.base) shift(*other.base);
    shifted.emplace_back(other);
  }
}

Calibration::Calibration(const Description& description, double wavelength_nm,
                         const PerFrequency& frequency, const inverse::FarSides& far)
    : frequency_(frequency),
      far_(far),
      errors_(description.errors.value_or(Errors{})),
      sample_(description.medium, wavelength_nm, (description.folder / file_name).string()),
      by_phantom_(description.reference.has_value()) {
  if (!by_phantom_) {
    scale_ = PerFrequency::Constant(frequency.size(), 1.0 / *description.codes_per_reflectance);
    return;
  }
  const std::string file = (description.folder / file_name).string();
  const PhantomRow row =
      row_at(description.reference->coefficients, wavelength_nm, file, "reference");
  const LateralCoefficients phantom{row.absorption_per_mm, row.reduced_scattering_per_mm};
  Medium medium = description.medium;
  medium.thickness_mm = description.reference->thickness_mm;
  medium.slide_index.reset();
  medium.cover.reset();
  medium.base.reset();
  const Models models(medium, wavelength_nm, file);
  const PerFrequency stated = logarithms(models.stated, phantom);
  scale_ = stated.array().exp();
  const auto deviation = row.relative_deviation.value_or(std::array<double, 2>{});
  phantom_errors_ = {
      logarithms(models.stated, {phantom.mua * (1.0 + deviation[0]), phantom.musp}) - stated,
      logarithms(models.stated, {phantom.mua, phantom.musp * (1.0 + deviation[1])}) - stated};
  for (const forward::LateralReflectance& model : models.shifted) {
    phantom_shifts_.push_back(logarithms(model, phantom) - stated);
  }
  phantom_table_ = PerFrequency::Zero(frequency.size());
  for (Eigen::Index i = 0; i < frequency.size(); ++i) {
    phantom_table_[i] = table_error(models.stated, i, phantom);
  }
}

PerFrequency Calibration::logarithms(const forward::LateralReflectance& model,
                                     const LateralCoefficients& at) const {
  PerFrequency result(frequency_.size());
  for (Eigen::Index i = 0; i < frequency_.size(); ++i) {
    result[i] = std::log(
        inverse::seen(model, far_[static_cast<std::size_t>(i)], frequency_[i], at.mua, at.musp)
            .reflectance);
  }
  return result;
}

double Calibration::table_error(const forward::LateralReflectance& model, Eigen::Index i,
                                const LateralCoefficients& at) const {
  return far_[static_cast<std::size_t>(i)] ? model.transmittance_error()
                                           : model.relative_error(frequency_[i], at.mua, at.musp);
}

Eigen::Matrix2d Calibration::Shared::total() const {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const Eigen::Matrix2d& one : covariance) sum += one;
  return sum;
}

std::vector<std::pair<Part, PerFrequency>> Calibration::log_errors(
    const LateralCoefficients& at) const {
  std::vector<std::pair<Part, PerFrequency>> all;
  const Eigen::Index n = frequency_.size();
  const auto add_each = [&](Part part, const PerFrequency& errors) {
    for (Eigen::Index i = 0; i < n; ++i) {
      PerFrequency one = PerFrequency::Zero(n);
      one[i] = errors[i];
      all.emplace_back(part, one);
    }
  };
  // A ratio of two objects has both objects' errors.
  const double objects = by_phantom_ ? std::sqrt(2.0) : 1.0;
  all.emplace_back(Part::pictures, PerFrequency::Constant(n, objects * errors_.common));
  add_each(Part::pictures, PerFrequency::Constant(n, objects * errors_.own));
  for (const PerFrequency& error : phantom_errors_) all.emplace_back(Part::phantom, error);
  const PerFrequency stated = logarithms(sample_.stated, at);
  for (std::size_t i = 0; i < sample_.shifted.size(); ++i) {
    PerFrequency shift = logarithms(sample_.shifted[i], at) - stated;
    if (by_phantom_ && i < phantom_shifts_.size()) shift -= phantom_shifts_[i];
    all.emplace_back(Part::medium, shift);
  }
  PerFrequency table(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    table[i] =
        std::hypot(table_error(sample_.stated, i, at), by_phantom_ ? phantom_table_[i] : 0.0);
  }
  add_each(Part::table, table);
  return all;
}

Calibration::Shared Calibration::shared_errors(const inverse::LateralFit& fit) const {
  Shared shared;
  shared.covariance.fill(Eigen::Matrix2d::Zero());
  for (const auto& [part, error] : log_errors(fit.coefficients)) {
    const Eigen::Vector2d moved = fit.gain * error;
    shared.covariance[static_cast<std::size_t>(part)] += moved * moved.transpose();
  }
  return shared;
}

Eigen::MatrixXd Calibration::log_covariance(const LateralCoefficients& at) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(frequency_.size(), frequency_.size());
  for (const auto& [part, error] : log_errors(at)) sum += error * error.transpose();
  return sum;
}

}  // namespace kappamu::pipeline::sfdi
