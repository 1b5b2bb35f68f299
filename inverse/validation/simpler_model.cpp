#include "inverse/validation/simpler_model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/shown_text.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/defaults.h"
#include "inverse/problem/fields.h"
#include "inverse/problem/predict.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::simpler_model;

struct Difference {
  double mean = 0.0;   ///< χ² per value of the first prediction less that of the second
  double error = 0.0;  ///< its standard deviation
};

/// Predictions [M][v][u] in the measured quantity.
Difference compare(const Problem& problem, double per_value, const std::vector<float>& first,
                   const std::vector<float>& second) {
  const FaceShape face = problem.seen_shape();
  const int across = (face.nu + block_edge - 1) / block_edge;
  const int down = (face.nv + block_edge - 1) / block_edge;
  std::vector<double> blocks(static_cast<std::size_t>(across * down * problem.patterns), 0.0);
  std::size_t i = 0;
  for (int m = 0; m < problem.patterns; ++m) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u, ++i) {
        const double a = per_value * first[i] - problem.data[i];
        const double b = per_value * second[i] - problem.data[i];
        const int block = (m * down + v / block_edge) * across + u / block_edge;
        blocks[static_cast<std::size_t>(block)] += problem.weight[i] * (a * a - b * b);
      }
    }
  }
  const auto count = static_cast<double>(blocks.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const double x : blocks) {
    sum += x;
    squares += x * x;
  }
  const double variance = std::max(0.0, squares - sum * sum / count);
  const auto data = static_cast<double>(problem.used());
  return {sum / data, std::sqrt(variance) / data};
}

/// The report as that of the fit of `layers`.
void take(FitReport& report, const LayeredMedium& layers, const Difference& difference) {
  ModelChoice& choice = report.model;
  choice.layers = layers.layers();
  choice.model = choice.layers == 1 ? Model::homogeneous : Model::layered;
  for (const ModelTrial& trial : choice.trials) {
    if (trial.level == 0 && trial.layers == choice.layers) {
      report.chi2_per_value = trial.chi2_per_value;
    }
  }
  report.status = FitStatus::above_noise;
  choice.reason += formatted(
      " Yet a volume predicts the validation patterns no better (chi2 per value there, %s less the "
      "volume's: %.3g, sampling error %.2g), so the simpler block is kept.",
      choice.layers == 1 ? "the homogeneous block's" : "the layers'", difference.mean,
      difference.error);
  report.reason =
      formatted("%s at chi2 per value %.3g, kept for the validation patterns.",
                choice.layers == 1 ? "A homogeneous block" : "Even layers", report.chi2_per_value);
}

}  // namespace

void prefer_simpler(ChannelFit& fit, const SurfaceMeasurements& fitted,
                    const SurfaceMeasurements& validation, int channel, const FitOptions& options) {
  if (fit.simpler.empty() || options.path.model != Model::automatic) return;
  PredictOptions predicting = predict_options(options, fit.report.physics);
  predicting.channel = channel;
  const Problem problem =
      make_problem(validation, channel, options.data.convention, options.data.model_error);
  if (problem.used() == 0) return;
  const double per_value = exitance_per_value(validation, problem.setup);
  const std::vector<float> volume = predict(fit.medium, validation, predicting);
  for (const LayeredMedium& layers : fit.simpler) {
    Medium medium = to_medium(to_fields(layers, forward::block_space(fitted.grid, fitted.lit_face)),
                              fitted.grid);
    const Difference difference =
        compare(problem, per_value, predict(medium, validation, predicting), volume);
    if (difference.mean > difference.error) continue;
    fit.prediction = predict(medium, fitted, predicting);
    fit.medium = std::move(medium);
    fit.prior.reset();
    take(fit.report, layers, difference);
    const Problem data =
        make_problem(fitted, channel, options.data.convention, options.data.model_error);
    std::vector<double> exitance(fit.prediction.begin(), fit.prediction.end());
    for (double& value : exitance) value *= exitance_per_value(fitted, data.setup);
    fit.report.shared = shared_errors(data, options.data.term, exitance);
    return;
  }
}

}  // namespace kappamu::inverse
