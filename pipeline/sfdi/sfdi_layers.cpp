#include "pipeline/sfdi/sfdi_layers.h"

#include <cmath>

#include "core/shown_text.h"
#include "forward/lateral/layered_transport.h"
#include "inverse/lateral/two_layer_fit.h"

namespace kappamu::pipeline::sfdi {

namespace {

/// Of transport in layers, beside the table's of a half-space.
constexpr double layers_error = 0.004;

constexpr std::array<const char*, 4> layer_coefficients{
    "mua of the upper layer", "musp of the upper layer", "mua of the lower layer",
    "musp of the lower layer"};

}  // namespace

bool cover_is_unknown(const Medium& medium) {
  return medium.cover && medium.cover->coefficients.empty();
}

TwoLayers find_layers(const Medium& medium, const Calibration& calibration,
                      const inverse::PerFrequency& frequency,
                      const inverse::PerFrequency& reflectance, const inverse::PerFrequency& noise,
                      const inverse::LateralCoefficients& start) {
  Eigen::MatrixXd covariance = calibration.log_covariance(start);
  covariance.diagonal().array() += noise.array().square() + layers_error * layers_error;
  const forward::LayeredTransport transport(medium.refractive_index, medium.anisotropy);
  const inverse::TwoLayerFit fit = inverse::fit_two_layers(
      transport, *medium.cover->thickness_mm, frequency, reflectance, covariance, start);
  TwoLayers found{
      fit.upper, fit.lower, {}, {}, fit.chi_square, fit.converged, *medium.cover->thickness_mm};
  for (std::size_t i = 0; i < found.relative_deviation.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    found.relative_deviation[i] = std::sqrt(fit.covariance(k, k));
    found.determined[i] = fit.determined(k);
  }
  return found;
}

Layer as_cover(const TwoLayers& found, double thickness_mm, double wavelength_nm) {
  const PhantomRow row{wavelength_nm, found.upper.mua, found.upper.musp,
                       std::array{found.relative_deviation[0], found.relative_deviation[1]}};
  return {{row}, thickness_mm};
}

void add_layer_warnings(const std::string& label, const TwoLayers& found,
                        std::vector<std::string>& warnings) {
  if (!found.converged) {
    warnings.push_back(label + ": the fit of both layers did not converge; do not trust it.");
  }
  if (found.thickness_mm * found.upper.musp < inverse::thin_layer) {
    warnings.push_back(
        label +
        ": the upper layer is thinner than half a transport mean free path; coefficients may be "
        "wrong by a factor of 1.6 beyond their deviations: state those of the layer.");
  }
  for (std::size_t i = 0; i < found.determined.size(); ++i) {
    if (found.determined[i]) continue;
    warnings.push_back(label + ": these frequencies do not determine " + layer_coefficients[i] +
                       " (a factor of " +
                       shown_number(std::exp(found.relative_deviation[i]), "%.2g") +
                       ", one standard deviation); add frequencies, or state what is known.");
  }
}

}  // namespace kappamu::pipeline::sfdi
