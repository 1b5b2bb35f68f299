#include "studies/objects/object_bench.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "forward/registry.h"
#include "render/embree_caster.h"
#include "studies/objects/object_measurement.h"

namespace kappamu::studies {

namespace {

constexpr Coefficients marble{0.152, 0.0021};  // red, Jensen et al. 2001
constexpr double mean_free_paths = 24.0, cost_eta = 1.5;
/// Models whose seconds grow with the square of the triangles, or that hold matrices of them.
constexpr std::size_t most_of_slow = 10'000;

bool slow(const std::string& model) {
  return model == "dipole" || model == "boundary_integral";
}

}  // namespace

void measure_costs(const Request& request, Progress& progress, const Save& save) {
  const ObjectSettings settings = object_settings(request);
  std::vector<int> tessellations{12, 24, 48, 96, 192};
  if (request.size == Size::quick) tessellations.resize(1);
  forward::ObjectOptions options;
  options.tolerance = request.number("tolerance", 0.03);
  const auto photons = static_cast<std::uint64_t>(request.number("photons", 5e4));
  options.device = request.device;
  Json rows = Json::array();
  for (const int tessellation : tessellations) {
    const TriangleMesh mesh =
        make_shape("torus", 3.0 * marble.kappa * mean_free_paths, tessellation);
    const Surface surface = surface_of(mesh);
    const auto rays = render::make_embree_caster(mesh);
    const ObjectMedium medium(marble);
    const std::vector<forward::ObjectLight> sky{{{}, std::vector<double>(surface.size(), 1.0)}};
    for (const std::string& model : settings.models) {
      if (slow(model) && surface.size() > most_of_slow) continue;
      Json row{{"model", model}, {"triangles", surface.size()}};
      try {
        const SpentTime spent;
        const forward::ObjectResult result =
            make_walking(model, photons)
                ->solve({mesh, surface, *rays, medium, cost_eta, sky}, options, progress);
        spent.record(row);
        row["elements"] = result.elements;
        row["error_estimate"] = result.error_estimate.front();
        rows.push_back(std::move(row));
        save({{"tolerance", options.tolerance}, {"photons", photons}, {"rows", rows}});
      } catch (const InputError&) {  // `grid`: no box of whole voxels
      }
    }
  }
}

}  // namespace kappamu::studies
