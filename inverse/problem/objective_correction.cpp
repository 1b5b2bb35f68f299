// The correction r of an objective: from a finer grid, and from photons where transport is asked
// for.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "inverse/defaults.h"
#include "inverse/problem/objective.h"
#include "inverse/problem/on_device/refined_exitance.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::correction;

}  // namespace

double Objective::refresh_correction(const Refinement& refinement, const CoefficientPair& fields,
                                     PhotonSlope photon_slope) {
  const bool slope = photon_slope == PhotonSlope::renewed && refinement.photons.has_value();
  const GridShape& shape = refinement.setup.shape;
  const GridShape& own = problem_.setup.shape;
  const std::unique_ptr<forward::DiffusionOperator> finer =
      backend_.make(refinement.setup, views_.faces()).op;
  const bool on_device = all_on_device_ && finer->on_device() != nullptr;
  const auto split = [&](const std::vector<double>& logs) {
    if (on_device && !refinement.photons) return std::vector<double>();
    return split_voxels(exponential(logs), own, shape, 2);
  };
  const std::vector<double> kappa = split(fields.log_kappa), mu = split(fields.log_mu);
  const int batch =
      bounded_batch(shape, backend_.batch, backend_.refined_memory_mb, backend_.precision);
  const std::vector<double> light = views_.of_lights(refinement.irradiance);
  // Begun with the light of this grid: one iteration of four is saved.
  const Guess guess = [&](int first, forward::BatchField& phi) {
    finer->interpolate(*fluence_[static_cast<std::size_t>(first / backend_.batch)], own,
                       first % backend_.batch, phi);
  };
  // Of the medium that this grid's light was solved for last.
  const auto exitance_below = [&](double lower_kappa, double lower_mu) {
    ++solves_.refined;
    const auto scaled = [](std::vector<double> values, double lower) {
      for (double& x : values) x *= std::exp(-lower);
      return values;
    };
    const BatchedSolve solve{batch,
                             {backend_.refined_tolerance, backend_.solve.max_iterations},
                             &solves_.voxel_iterations,
                             guess};
    const FaceShape fine = face_shape(shape, problem_.seen_face);
    if (on_device) {
      set_split(*finer, {fields, own, {lower_kappa, lower_mu}});
      return views_.pictures(
          restricted_exitance(*finer, light, views_.lights(), fine, problem_.seen_shape(), solve));
    }
    finer->set_medium(scaled(kappa, lower_kappa), scaled(mu, lower_mu));
    const std::vector<double> leaving = solve_exitance(*finer, light, views_.lights(), solve);
    return restrict_face(views_.pictures(leaving), fine, problem_.seen_shape(), 2,
                         problem_.patterns);
  };
  const auto require_forward = [&](const CoefficientPair& at) {
    if (!solve_forward(at)) throw InputError("the diffusion solver failed at the current medium");
  };
  struct {
    std::array<std::vector<double>, 2> finer, own;
  } below;
  for (std::size_t k = 0; slope && k < 2; ++k) {
    CoefficientPair lower = fields;
    for (double& x : k == 0 ? lower.log_kappa : lower.log_mu) x -= slope_step;
    require_forward(lower);
    below.own[k] = exitance_;
    below.finer[k] = exitance_below(k == 0 ? slope_step : 0.0, k == 1 ? slope_step : 0.0);
  }
  require_forward(fields);
  std::vector<double> better = exitance_below(0.0, 0.0);
  Correction correction;
  if (refinement.photons) {
    misfit();  // with the r that is to be replaced
    PhotonProblem walk{refinement.setup,
                       kappa,
                       mu,
                       refinement.irradiance,
                       problem_.seen_face,
                       problem_.seen_faces,
                       problem_.seen_shape(),
                       2,
                       problem_.patterns,
                       problem_.cameras,
                       better};
    const double chi2 = data_term_.chi2_per_value;
    const double excess = std::isfinite(chi2) ? std::max(1.0, chi2) : 1.0;
    for (const double weight : stated_weight_) {
      walk.variance.push_back(excess / weight);  // infinite where nothing is measured
    }
    if (slope) walk.diffusion_below = below.finer;
    PhotonRatio transport = photon_ratio(walk, *refinement.photons);
    solves_.photons += static_cast<double>(transport.photons) * problem_.patterns;
    for (std::size_t k = 0; slope && k < 2; ++k) {  // and that of the grid's own share
      for (std::size_t i = 0; i < better.size(); ++i) {
        const double change =
            std::log(better[i] / below.finer[k][i] * below.own[k][i] / exitance_[i]);
        if (std::isfinite(change)) transport.slope[k][i] += change / slope_step;
      }
    }
    for (std::size_t i = 0; i < better.size(); ++i) better[i] *= transport.ratio[i];
    correction.variance = std::move(transport.variance);
    correction.pixel_variance = std::move(transport.pixel_variance);
    correction.slope = slope ? std::move(transport.slope) : std::move(correction_.slope);
    correction.mean = means(fields);
  }
  if (lit_) {
    const std::array<double, 2> even = means(fields);
    const std::vector<double> lit = lit_->exitance(std::exp(even[0]), std::exp(even[1]));
    for (std::size_t i = 0; i < better.size(); ++i) {
      if (lit[i] <= 0.0) continue;
      better[i] = lit[i];
      if (!correction.variance.empty()) {
        correction.variance[i] = correction.pixel_variance[i] = 0.0;
      }
    }
  }
  for (std::size_t i = 0; i < better.size(); ++i) {
    const double ratio = better[i] / exitance_[i];
    correction.ratio.push_back(
        std::isfinite(ratio) ? std::clamp(ratio, min_correction, max_correction) : 1.0);
  }
  set_correction(std::move(correction));
  return misfit();
}

/// Means of log κ and log μ over the voxels.
std::array<double, 2> Objective::means(const CoefficientPair& fields) {
  const auto of = [](const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  return {of(fields.log_kappa), of(fields.log_mu)};
}

/// r at the fields of the last value().
void Objective::correct() {
  ratio_ = correction_.ratio;
  const bool constant = correction_.slope[0].empty() && correction_.slope[1].empty();
  if (constant || (fields_.log_kappa.empty() && !device_means_)) return;
  const std::array<double, 2> at = device_means_ ? *device_means_ : means(fields_);
  for (std::size_t k = 0; k < 2 && !correction_.slope[k].empty(); ++k) {
    const double change = at[k] - correction_.mean[k];
    for (std::size_t i = 0; i < ratio_.size(); ++i) {
      ratio_[i] *= std::exp(correction_.slope[k][i] * change);
    }
  }
}

/// Weights of the stated variances and `more`.
void Objective::add_to_variance(const std::vector<double>& more) {
  data_on_device_ = false;
  problem_.weight = stated_weight_;
  problem_.correction_variance = more;
  for (std::size_t i = 0; i < more.size(); ++i) {
    if (stated_weight_[i] > 0.0) problem_.weight[i] = 1.0 / (1.0 / stated_weight_[i] + more[i]);
  }
}

void Objective::set_correction(Correction correction) {
  const std::size_t data = problem_.data.size();
  check(correction.ratio.size() == data &&
            correction.variance.size() == correction.pixel_variance.size() &&
            (correction.variance.empty() || correction.variance.size() == data),
        "correction does not fit the data");
  correction_ = std::move(correction);
  correct();
  add_to_variance(correction_.variance);
}

void Objective::count_all_errors() {
  if (problem_.precision) problem_.precision->hold_mean(false);
  add_to_variance(correction_.pixel_variance);
  if (!fluence_.empty()) misfit();
}

void Objective::restore(Correction correction, const SolveCount& solves) {
  set_correction(std::move(correction));
  solves_ = solves;
}

}  // namespace kappamu::inverse
