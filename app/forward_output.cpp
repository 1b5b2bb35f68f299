#include "app/forward_output.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "forward/grid/grid_physics.h"
#include "io/npy.h"
#include "io/volume/volume_export.h"
#include "io/volume/volume_file.h"

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

void write_fluence(const std::filesystem::path& folder, FluenceFormat format, const ForwardRun& run,
                   const forward::ForwardResult& result) {
  const GridShape& shape = run.setup.shape;
  const std::pair<const char*, const std::vector<double>*> kinds[] = {
      {"", &result.fluence}, {"standard_error_", &result.fluence_error}};
  if (format == FluenceFormat::npy) {
    for (const auto& [prefix, values] : kinds) {
      if (values->empty()) continue;
      const std::vector<float> stored(values->begin(), values->end());
      io::write_npy(folder / (std::string(prefix) + "fluence.npy"),
                    {static_cast<std::size_t>(run.patterns), static_cast<std::size_t>(shape.nz),
                     static_cast<std::size_t>(shape.ny), static_cast<std::size_t>(shape.nx)},
                    std::span<const float>(stored));
    }
    return;
  }
  std::vector<Volume<double>> volumes;
  std::vector<std::string> names;
  for (const auto& [prefix, values] : kinds) {
    for (auto at = values->begin(); at != values->end();) {
      const auto end = at + static_cast<std::ptrdiff_t>(shape.cells());
      names.push_back(prefix + ("phi_" + std::to_string((end - values->begin()) / (end - at) - 1)));
      volumes.emplace_back(shape, std::vector<double>(at, end));
      at = end;
    }
  }
  std::vector<io::NamedVolume> named;
  for (std::size_t i = 0; i < names.size(); ++i)
    named.push_back({names[i], "unit of the irradiance", &volumes[i]});
  if (format == FluenceFormat::vdb) {
    io::write_vdb(folder / "fluence.vdb", named);
  } else {
    io::export_vti(folder / "fluence.vti", named);
  }
}

std::vector<std::string> forward_outputs() {
  std::vector<std::string> names{"summary.json", "fluence.npy", "standard_error_fluence.npy",
                                 "fluence.vti", "fluence.vdb"};
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
  Json points = Json::array();
  for (const forward::PointSource& point : run.light.points) {
    const Eigen::Vector3d& at = point.position_mm;
    points.push_back({{"position_mm", {at.x(), at.y(), at.z()}}, {"power", point.power}});
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
                  {"direction", nullptr},
                  {"points", points},
                  {"units", {{"power", "mm^2 times the unit of irradiance"}, {"length", "mm"}}},
                  {"patterns", patterns}});
  if (run.light.direction) {
    const Eigen::Vector3d d = run.light.direction->normalized();
    summary["direction"] = {d.x(), d.y(), d.z()};
  }
  return summary;
}

}  // namespace kappamu::app
