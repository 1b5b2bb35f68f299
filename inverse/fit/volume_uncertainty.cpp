#include "inverse/fit/volume_uncertainty.h"

#include <algorithm>

#include "core/error.h"
#include "inverse/fit/channel_run.h"

namespace kappamu::inverse {

std::optional<double> shared_prior_weight(std::span<const ChannelFit> fits) {
  std::optional<double> lowest;
  for (const ChannelFit& fit : fits) {
    if (fit.prior) lowest = std::min(lowest.value_or(fit.prior->weight), fit.prior->weight);
  }
  return lowest;
}

Uncertainty estimate_volume_uncertainty(const ChannelFit& fit, double prior_weight,
                                        const SurfaceMeasurements& fitted, int channel,
                                        const FitOptions& options) {
  check(fit.prior.has_value(), "uncertainty: the fit has no prior");
  GridPath grid = make_grid_path(fitted, channel, options);
  grid.open(0);
  Objective& objective = grid.objective();
  objective.set_correction(fit.correction);
  objective.value(to_fields(fit.medium));
  objective.count_pixel_noise();
  Prior prior = *fit.prior;
  prior.weight = prior_weight;
  return estimate_uncertainty(objective, prior, options.uncertainty, options.solver.seed);
}

}  // namespace kappamu::inverse
