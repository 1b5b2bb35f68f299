#include "inverse/problem/predict.h"

#include "core/error.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

std::vector<float> predict(const Medium& medium, const SurfaceMeasurements& light,
                           const PredictOptions& options) {
  const GridShape& shape = light.grid;
  if (!(medium.kappa.shape() == shape) || !(medium.mu.shape() == shape)) {
    throw InputError("the volume does not have the grid of the measurements");
  }
  forward::GridSetup setup = make_setup(light, options.convention);
  setup.shape = shape.refined(options.refine);
  const auto solver =
      forward::make_grid_solver(setup, options.backend.device, options.backend.precision).solver;
  solver->set_medium(split_voxels(medium.kappa.values(), shape, setup.shape, options.refine),
                     split_voxels(medium.mu.values(), shape, setup.shape, options.refine));
  const std::vector<double> incident(light.irradiance.begin(), light.irradiance.end());
  const int batch = bounded_batch(setup.shape, options.backend.batch,
                                  options.backend.refined_memory_mb, options.backend.precision);
  const std::vector<double> exitance = restrict_face(
      solve_exitance(
          *solver, light.seen_face,
          split_face(incident, light.lit_shape(), face_shape(setup.shape, setup.lit_face),
                     options.refine, light.patterns),
          light.patterns, batch, options.backend.solve),
      face_shape(setup.shape, light.seen_face), light.seen_shape(), options.refine, light.patterns);
  const double per_value = exitance_per_value(light, setup);
  std::vector<float> values;
  values.reserve(exitance.size());
  for (const double m : exitance) values.push_back(static_cast<float>(m / per_value));
  return values;
}

}  // namespace kappamu::inverse
