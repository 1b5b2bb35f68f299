#include "app/forward_output.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "forward/grid/grid_physics.h"
#include "io/npy.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;

void write_map(const std::filesystem::path& file, const FaceShape& face, int patterns,
               const std::vector<double>& map) {
  const std::vector<float> stored(map.begin(), map.end());
  io::write_npy(file,
                {static_cast<std::size_t>(patterns), static_cast<std::size_t>(face.nv),
                 static_cast<std::size_t>(face.nu)},
                std::span<const float>(stored));
}

Json pattern_summary(const forward::ForwardResult& result, std::size_t m) {
  const forward::PowerBalance& balance = result.balance[m];
  Json exiting;
  for (std::size_t f = 0; f < all_faces.size(); ++f) {
    exiting[to_string(all_faces[f])] = balance.exiting[f];
  }
  Json pattern{{"entering", balance.entering},
               {"exiting", exiting},
               {"unscattered", balance.unscattered},
               {"absorbed", balance.absorbed}};
  if (!result.residual.empty()) pattern["residual"] = result.residual[m];
  return pattern;
}

}  // namespace

void write_maps(const std::filesystem::path& folder, const ForwardRun& run,
                const forward::ForwardResult& result) {
  for (std::size_t f = 0; f < all_faces.size(); ++f) {
    const FaceShape face = face_shape(run.setup.shape, all_faces[f]);
    const std::string name = to_string(all_faces[f]) + ".npy";
    write_map(folder / ("exitance_" + name), face, run.patterns, result.exitance[f]);
    if (result.standard_error[f].empty()) continue;
    write_map(folder / ("standard_error_" + name), face, run.patterns, result.standard_error[f]);
  }
}

std::vector<std::string> forward_outputs() {
  std::vector<std::string> names{"summary.json"};
  for (const Face face : all_faces) {
    names.push_back("exitance_" + to_string(face) + ".npy");
    names.push_back("standard_error_" + to_string(face) + ".npy");
  }
  return names;
}

Json forward_summary(const ForwardRun& run, const forward::ForwardResult& result) {
  const forward::GridSetup& setup = run.setup;
  const GridShape& s = setup.shape;
  const BoundaryConstants constants = forward::constants_of(setup);
  const bool first_collision = setup.source == forward::SourceModel::first_collision;
  const bool physical = setup.convention == forward::Convention::physical;
  Json patterns = Json::array();
  for (std::size_t m = 0; m < result.balance.size(); ++m) {
    patterns.push_back(pattern_summary(result, m));
  }
  Json summary{{"method", run.method},
               {"converged", result.termination == forward::Termination::converged},
               {"message", result.message},
               {"iterations", result.iterations}};
  if (!result.residual.empty()) {
    summary["residual"] = *std::max_element(result.residual.begin(), result.residual.end());
    summary["tolerance"] = run.options.solve.tolerance;
  }
  if (!result.standard_error.front().empty()) {
    summary["photons"] = result.photons;
    summary["anisotropy"] = run.options.anisotropy;
    summary["seed"] = run.options.seed;
  }
  summary.update({{"seconds", result.seconds},
                  {"setup_seconds", result.setup_seconds},
                  {"backend", result.backend},
                  {"grid", {s.nx, s.ny, s.nz}},
                  {"voxel_mm", s.voxel_mm},
                  {"eta", setup.eta},
                  {"A", constants.A},
                  {"normal_transmittance", constants.normal_transmittance},
                  {"lit_face", to_string(setup.lit_face)},
                  {"sides", to_string(setup.sides)},
                  {"source", first_collision ? "first-collision" : "boundary"},
                  {"convention", physical ? "physical" : "wang2008"},
                  {"units", {{"power", "mm^2 times the unit of irradiance"}, {"length", "mm"}}},
                  {"patterns", patterns}});
  return summary;
}

}  // namespace kappamu::app
