#include "inverse/validation/notes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/numbers/median.h"
#include "core/shown_text.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::notes;

std::optional<std::string> fine_voxels(const Medium& medium) {
  const double path =
      3.0 * upper_median<double>({medium.kappa.values().begin(), medium.kappa.values().end()});
  const double h = medium.kappa.shape().voxel_mm;
  const GridShape& shape = medium.kappa.shape();
  const double thinnest = h * std::min({shape.nx, shape.ny, shape.nz});
  if (h >= fine_voxel * path || advised_voxel * path * fewest_voxels > thinnest) {
    return std::nullopt;
  }
  return formatted(
      "The voxels of %.3g mm are %.2g of a mean free path (3 kappa): light carries no "
      "structure finer than that, and voxels of %.2g mm show as much from %.0f times "
      "fewer.",
      h, h / path, advised_voxel * path, std::pow(advised_voxel * path / h, 3));
}

/// Errors that the variances leave out appear under light that was not fitted. The fit absorbs
/// those of the fitted light.
std::optional<std::string> validation_misfit(const ChannelFit& fit,
                                             const ValidationScore& validation) {
  const double chi2 = validation.chi2_per_value;
  if (chi2 < surprising_chi2 * std::max(1.0, fit.report.chi2_per_value)) return std::nullopt;
  return formatted(
      "Validation patterns deviate from the prediction by %.2g of their stated standard "
      "deviations, fitted ones by %.2g: the variances leave something out, and at the "
      "seen face the errors of kappa and mu may be as many of theirs.",
      std::sqrt(chi2), std::sqrt(fit.report.chi2_per_value));
}

}  // namespace

std::optional<std::string> unseen_warning(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                          int channel) {
  if (fit.report.model.model != Model::volume || fitted.mask.empty()) return std::nullopt;
  const std::size_t cells = fitted.seen_shape().cells();
  const auto patterns = static_cast<std::size_t>(fitted.patterns);
  const std::size_t first = static_cast<std::size_t>(channel) * patterns * cells;
  std::size_t unseen = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    bool seen = false;
    for (std::size_t m = 0; m < patterns && !seen; ++m) {
      seen = fitted.mask[first + m * cells + i] != 0;
    }
    unseen += seen ? 0 : 1;
  }
  const double share = static_cast<double>(unseen) / static_cast<double>(cells);
  if (share < much_unseen) return std::nullopt;
  return formatted(
      "%.0f %% of the seen face is measured under no pattern (masks): beneath it kappa "
      "and mu are what neighbours and smoothing make of them. Photograph it, or trust "
      "them only within std_kappa and std_mu.",
      100.0 * share);
}

std::optional<std::string> outlier_warning(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                           int channel, std::span<const int> kept_out) {
  if (fit.report.chi2_per_value < high_chi2) return std::nullopt;
  const std::size_t first = static_cast<std::size_t>(channel) * fit.prediction.size();
  const std::size_t of_pattern = fit.prediction.size() / static_cast<std::size_t>(fitted.patterns);
  std::vector<double> deviation;        // in stated standard deviations
  std::vector<std::size_t> pattern_of;  // each
  for (std::size_t i = 0; i < fit.prediction.size(); ++i) {
    if (!fitted.mask.empty() && fitted.mask[first + i] == 0) continue;
    const double misfit = fitted.value[first + i] - fit.prediction[i];
    deviation.push_back(std::abs(misfit) / std::sqrt(fitted.variance[first + i]));
    pattern_of.push_back(i / of_pattern);
  }
  constexpr double median_of_normal = 0.6745;
  const double bound = far * upper_median(deviation) / median_of_normal;
  double all = 0.0, outliers = 0.0;
  std::size_t count = 0;
  std::vector<double> by_pattern(static_cast<std::size_t>(fitted.patterns));
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    const double e = deviation[i];
    all += e * e;
    if (e <= bound) continue;
    outliers += e * e;
    by_pattern[pattern_of[i]] += e * e;
    ++count;
  }
  const double share = static_cast<double>(count) / static_cast<double>(deviation.size());
  if (outliers < 0.5 * all || share > few) return std::nullopt;
  const std::string size =
      formatted("%.2g %% of the values are outliers that make %.0f %% of chi2 and bend the fit",
                100.0 * share, 100.0 * outliers / all);
  const auto worst = std::max_element(by_pattern.begin(), by_pattern.end());
  constexpr double most = 0.7;
  if (fitted.patterns > 1 && *worst >= most * outliers) {
    auto number = static_cast<int>(worst - by_pattern.begin());
    for (const int out : kept_out) number += out <= number ? 1 : 0;
    return size +
           formatted(
               ", most of them under pattern %d (from 0): look at its photographs, their exposure "
               "times and what was projected, then photograph it again or leave it out.",
               number);
  }
  return size + ": mask them, or fit with the loss student, which is robust to outliers.";
}

std::vector<std::string> notes_on(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                  const std::optional<ValidationScore>& validation) {
  std::vector<std::string> notes;
  if (!fit.report.physics_reason.empty()) notes.push_back(fit.report.physics_reason);
  const std::string checked = in_words(fit.report.consistency, fitted.eta);
  if (!checked.empty()) notes.push_back(checked);
  if (fit.report.model.model == Model::volume) {
    if (const auto fine = fine_voxels(fit.medium)) notes.push_back(*fine);
  }
  if (validation) {
    if (const auto off = validation_misfit(fit, *validation)) notes.push_back(*off);
  }
  return notes;
}

}  // namespace kappamu::inverse
