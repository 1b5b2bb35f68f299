// A fit from folder to folder, with every option described, and its measurements.
#include <nlohmann/json.hpp>

#include "core/surface_measurements.h"
#include "io/measurements_file.h"
#include "pipeline/fit_files.h"
#include "pipeline/fit_folder.h"
#include "pipeline/stages/continuation.h"
#include "python/bindings/bind.h"
#include "python/bindings/listener.h"

namespace kappamu::python {

namespace {

/// Sets one option at a time, so that the option at fault is known.
void set(pipeline::FitStageOptions& options, const std::string& json) {
  const nlohmann::json given = nlohmann::json::parse(json);
  for (const auto& [key, value] : given.items()) {
    try {
      pipeline::set_options(options, nlohmann::json{{key, value}}.dump());
    } catch (const InputError& error) {
      const std::string sentence = error.what();
      throw KeyedError(key, sentence.starts_with(key) ? sentence : key + ": " + sentence);
    }
  }
}

std::string fit(const std::filesystem::path& input, const std::filesystem::path& out,
                const std::optional<std::filesystem::path>& validate,
                const std::optional<std::filesystem::path>& continued, bool restart,
                const std::string& json, const py::object& progress) {
  pipeline::FitStageOptions options = pipeline::usual_options();
  if (continued) pipeline::FinishedFit(*continued).set_options(options);
  set(options, json);
  options = pipeline::resolve(options);
  options.validate = validate;
  options.restart = restart;
  std::string folder;
  listen(progress, [&](const std::shared_ptr<Mail>& mail) {
    MailProgress listener(mail);
    folder = pipeline::fit_folder({input, out, continued}, options, listener)
                 .volume.parent_path()
                 .string();
  });
  return folder;
}

SurfaceMeasurements measurements_from(const py::dict& fields) {
  SurfaceMeasurements m;
  const auto grid = fields["grid"].cast<std::array<int, 3>>();
  m.grid = {grid[0], grid[1], grid[2], value_of_key<double>(fields, "voxel_mm")};
  m.eta = value_of_key<double>(fields, "eta");
  const auto text = [&fields](const char* key) { return value_of_key<std::string>(fields, key); };
  m.lit_face = named(face_names, text("lit_face"), "lit_face");
  m.seen_face = named(face_names, text("seen_face"), "seen_face");
  for (const auto& face : fields["seen_faces"].cast<std::vector<std::string>>())
    m.seen_faces.push_back(named(face_names, face, "seen_faces"));
  for (const auto& [face, place] :
       fields["camera_mm"].cast<std::map<std::string, std::array<double, 3>>>())
    m.cameras[named(face_names, face, "camera_mm")] = {place[0], place[1], place[2]};
  m.quantity = named(quantity_names, text("quantity"), "quantity");
  m.light = named(light_names, text("light"), "light");
  m.sides = named(sides_names, text("sides"), "sides");
  m.channels = fields["channels"].cast<std::vector<std::string>>();
  const auto irradiance = numbers<float>(fields["irradiance"], "irradiance");
  m.patterns = irradiance.ndim() == 3 ? static_cast<int>(irradiance.shape(0)) : 0;
  require_shape(irradiance, extents(m.patterns, m.lit_shape()), "irradiance", "[M][v][u]");
  m.irradiance = copy(irradiance);
  std::vector<py::ssize_t> seen = extents(m.patterns, m.seen_shape());
  seen.insert(seen.begin(), static_cast<py::ssize_t>(m.channels.size()));
  const auto map = [&]<class T>(const char* key, std::vector<T>& values) {
    const auto array = numbers<T>(fields[key], key);
    require_shape(array, seen, key, "[C][M][v][u]");
    values = copy(array);
  };
  map("value", m.value);
  map("variance", m.variance);
  if (!fields["mask"].is_none()) map("mask", m.mask);
  return m;
}

py::dict to_dict(SurfaceMeasurements&& m) {
  std::vector<py::ssize_t> seen = extents(m.patterns, m.seen_shape());
  seen.insert(seen.begin(), static_cast<py::ssize_t>(m.channels.size()));
  py::dict fields;
  fields["grid"] = py::make_tuple(m.grid.nx, m.grid.ny, m.grid.nz);
  fields["voxel_mm"] = m.grid.voxel_mm;
  fields["eta"] = m.eta;
  fields["lit_face"] = to_string(m.lit_face);
  fields["seen_face"] = to_string(m.seen_face);
  fields["seen_faces"] = py::none();
  if (m.two_faces()) {
    py::list faces;
    for (const Face face : m.seen_faces) faces.append(to_string(face));
    fields["seen_faces"] = faces;
  }
  py::dict cameras;
  for (const auto& [face, place] : m.cameras)
    cameras[py::str(to_string(face))] = py::make_tuple(place.x(), place.y(), place.z());
  fields["camera_mm"] = cameras;
  fields["quantity"] = to_string(m.quantity);
  fields["light"] = to_string(m.light);
  fields["sides"] = to_string(m.sides);
  fields["channels"] = m.channels;
  fields["irradiance"] = take(std::move(m.irradiance), extents(m.patterns, m.lit_shape()));
  fields["value"] = take(std::move(m.value), seen);
  fields["variance"] = take(std::move(m.variance), seen);
  fields["mask"] = py::none();
  if (!m.mask.empty()) fields["mask"] = take(std::move(m.mask), seen);
  return fields;
}

}  // namespace

void bind_fit(py::module_& module) {
  module.def("fit", fit);
  module.def("fit_options", [] { return pipeline::options_json(pipeline::usual_options()); });
  module.def("fit_options_page", pipeline::options_page);
  module.def("read_measurements", [](const std::filesystem::path& folder) {
    return to_dict(io::read_measurements(pipeline::find_measurements(folder)));
  });
  module.def("write_measurements", [](const std::filesystem::path& folder, const py::dict& fields) {
    const SurfaceMeasurements measurements = measurements_from(fields);
    validate(measurements, "measurements");
    io::write_measurements(folder, measurements);
  });
}

}  // namespace kappamu::python
