#include "forward/diffusion_warnings.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/shown_text.h"
#include "forward/analytic/validity.h"

namespace kappamu::forward {

namespace {

/// A smaller share of the block than this is not worth a warning: a fit always has some voxel at
/// the end of its range.
constexpr double worthwhile_share = 0.01;

/// Voxel edge over mean free path 3κ above which the grid's own error of an even beam's reflected
/// and transmitted light exceeds 3 % (first collision) or 2 % (boundary): docs/limits.md, coarse.
double coarsest_voxel(SourceModel source) {
  return source == SourceModel::first_collision ? 1.0 : 4.0;
}

std::optional<std::string> much_absorption(const Medium& medium) {
  constexpr double much = 0.1;  // μ/σt', where P1 and transport part visibly
  std::size_t absorbing = 0, without_scattering = 0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    const double ratio = 3.0 * medium.kappa[i] * medium.mu[i];
    absorbing += ratio > much ? 1 : 0;
    without_scattering += ratio >= 1.0 ? 1 : 0;
  }
  const double share = static_cast<double>(absorbing) / static_cast<double>(medium.kappa.size());
  if (share < worthwhile_share && without_scattering == 0) return std::nullopt;
  std::string text = formatted(
      "%.3g %% of the voxels absorb more than a tenth of what they extinguish (3 kappa mu > 0.1); "
      "diffusion is inaccurate there",
      100.0 * share);
  if (without_scattering > 0) {
    text += formatted(", and in %zu voxels no scattering is left (3 kappa mu >= 1)",
                      without_scattering);
  }
  return text;
}

std::optional<std::string> coarse_voxels(const GridSetup& setup, const Medium& medium) {
  const double h = setup.shape.voxel_mm;
  const double limit = coarsest_voxel(setup.source);
  std::size_t coarse = 0;
  double worst = 0.0;
  for (const double kappa : medium.kappa.values()) {
    const double paths = h / (3.0 * kappa);
    // A voxel of just one mean free path is not beyond it for want of a last digit.
    coarse += paths > limit * (1.0 + 1e-9) ? 1 : 0;
    worst = std::max(worst, paths);
  }
  const double share = static_cast<double>(coarse) / static_cast<double>(medium.kappa.size());
  if (share < worthwhile_share) return std::nullopt;
  return formatted(
      "in %.3g %% of the block the voxel edge of %.3g mm is more than %.3g mean free path%s 3 "
      "kappa (up to %.3g); the grid's own error exceeds a few percent there: split the voxels "
      "and compare",
      100.0 * share, h, limit, limit > 1.0 ? "s" : "", worst);
}

std::optional<std::string> dark_far_side(const GridSetup& setup, const Medium& medium,
                                         Precision precision) {
  constexpr double most_decades = 6.0;     // the default tolerance's
  constexpr double double_decades = 13.0;  // what double still resolves
  double decay = 0.0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    decay += std::sqrt(medium.mu[i] / medium.kappa[i]);
  }
  const double depth = setup.thickness_mm();
  const double decades =
      decay / static_cast<double>(medium.kappa.size()) * depth / std::numbers::ln10;
  if (decades <= most_decades) return std::nullopt;
  const std::string text = formatted(
      "light falls by about %.3g decades across the block, more than the default tolerance "
      "resolves; what leaves the far face is rounding unless you ask for ",
      std::round(decades));
  if (decades > double_decades) return text + "a thinner block: no precision resolves it";
  return text + (precision == Precision::single_precision ? "double precision and " : "") +
         shown_number(std::ceil(decades), "the tolerance 1e-%.3g");
}

}  // namespace

std::vector<std::string> diffusion_warnings(const GridSetup& setup, const Medium& medium,
                                            Precision precision) {
  std::vector<std::string> warnings;
  for (const auto& sentence :
       {validity_warning(setup, medium), much_absorption(medium), coarse_voxels(setup, medium),
        dark_far_side(setup, medium, precision)}) {
    if (sentence) warnings.push_back(*sentence);
  }
  return warnings;
}

}  // namespace kappamu::forward
