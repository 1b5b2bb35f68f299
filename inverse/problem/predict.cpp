#include "inverse/problem/predict.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/error.h"
#include "inverse/defaults.h"
#include "inverse/problem/lit_face.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::predict;

/// `diffusion` [M][v][u], on pixels of factor² of the walk's, becomes transport's; `variance` of
/// the data beside it [M][v][u] or empty.
void by_transport(PhotonProblem walk, const PhotonOptions& options,
                  const std::vector<double>& variance, std::vector<double>& diffusion) {
  const std::size_t cells = walk.seen_shape.cells();
  for (std::size_t first = 0; first < diffusion.size(); first += cells) {
    const auto begin = diffusion.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(cells);
    const double floor = photon_noise_floor * *std::max_element(begin, end);
    std::transform(begin, end, std::back_inserter(walk.variance),
                   [&](double m) { return std::pow(photon_noise * m, 2) + floor * floor; });
  }
  for (std::size_t i = 0; i < variance.size(); ++i) {
    walk.variance[i] = std::max(walk.variance[i], variance[i]);
  }
  walk.diffusion = diffusion;
  const PhotonRatio transport = photon_ratio(walk, options);
  for (std::size_t i = 0; i < diffusion.size(); ++i) diffusion[i] *= transport.ratio[i];
}

}  // namespace

std::vector<float> predict(const Medium& medium, const SurfaceMeasurements& light,
                           const PredictOptions& options) {
  const GridShape& shape = light.grid;
  if (!(medium.kappa.shape() == shape) || !(medium.mu.shape() == shape)) {
    throw InputError("the volume does not have the grid of the measurements");
  }
  forward::GridSetup setup = make_setup(light, options.convention);
  setup.shape = shape.refined(options.refine);
  const std::vector<double> irradiance(light.irradiance.begin(), light.irradiance.end());
  const Views views(irradiance, light.patterns, light.seen_face, light.seen_faces);
  const auto op = options.backend.make(setup, views.faces()).op;
  const std::vector<double> kappa =
      split_voxels(medium.kappa.values(), shape, setup.shape, options.refine);
  const std::vector<double> mu =
      split_voxels(medium.mu.values(), shape, setup.shape, options.refine);
  op->set_medium(kappa, mu);
  const std::vector<double> incident =
      split_face(irradiance, light.lit_shape(), face_shape(setup.shape, setup.lit_face),
                 options.refine, light.patterns);
  const int batch = bounded_batch(setup.shape, options.backend.batch,
                                  options.backend.refined_memory_mb, options.backend.precision);
  std::vector<double> exitance = restrict_face(
      views.pictures(solve_exitance(*op, views.of_lights(incident), views.lights(),
                                    {batch, options.backend.solve})),
      face_shape(setup.shape, light.seen_face), light.seen_shape(), options.refine, light.patterns);
  const double per_value = exitance_per_value(light, setup);
  if (options.photons) {
    std::vector<double> variance;  // of exitance
    if (!light.variance.empty()) {
      const auto first = static_cast<std::ptrdiff_t>(exitance.size()) * options.channel;
      std::transform(light.variance.begin() + first,
                     light.variance.begin() + first + static_cast<std::ptrdiff_t>(exitance.size()),
                     std::back_inserter(variance),
                     [&](float v) { return per_value * per_value * v; });
    }
    by_transport({setup, kappa, mu, incident, light.seen_face, light.seen_faces, light.seen_shape(),
                  options.refine, light.patterns, cameras_of(light)},
                 *options.photons, variance, exitance);
  }
  if (!light.lit.empty()) {
    const Problem problem = make_problem(light, options.channel, options.convention, {});
    const CoefficientPair logs = to_fields(medium);
    const auto even = [](const std::vector<double>& values) {
      return std::exp(std::accumulate(values.begin(), values.end(), 0.0) /
                      static_cast<double>(values.size()));
    };
    std::vector<double> lit;
    if (!problem.lateral.empty()) {
      lit = LitFace(problem).exitance(even(logs.log_kappa), even(logs.log_mu));
    }
    for (std::size_t i = 0; i < lit.size(); ++i) {
      if (lit[i] > 0.0) exitance[i] = lit[i];
    }
  }
  std::vector<float> values;
  values.reserve(exitance.size());
  for (const double m : exitance) values.push_back(static_cast<float>(m / per_value));
  return values;
}

}  // namespace kappamu::inverse
