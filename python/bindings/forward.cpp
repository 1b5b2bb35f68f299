// Arrays of κ, μ and light to exitance by any method of forward/forward_model.h.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/forward_output.h"
#include "core/numbers/coefficient_bounds.h"
#include "forward/diffusion_warnings.h"
#include "forward/forward_model.h"
#include "inverse/fit/describe_options.h"
#include "python/bindings/bind.h"
#include "python/bindings/listener.h"

namespace kappamu::python {

namespace {

using Options = py::dict;

std::string text(const Options& options, const char* key) {
  return value_of_key<std::string>(options, key);
}

forward::GridSetup setup_of(const Options& options, const GridShape& shape) {
  forward::GridSetup setup;
  setup.shape = shape;
  setup.eta = value_of_key<double>(options, "eta");
  setup.lit_face = named(face_names, text(options, "lit_face"), "lit_face");
  setup.sides = named(sides_names, text(options, "sides"), "sides");
  setup.convention = named(inverse::convention_names, text(options, "convention"), "convention");
  setup.source = named(source_names, text(options, "source"), "source");
  return setup;
}

forward::ForwardOptions options_of(const Options& options) {
  forward::ForwardOptions o;
  o.device = text(options, "device");
  o.precision = named(inverse::precision_names, text(options, "precision"), "precision");
  o.solve = solve_options(options);
  o.seed = value_of_key<std::uint64_t>(options, "seed");
  o.photons = value_of_key<std::uint64_t>(options, "photons");
  o.anisotropy = value_of_key<double>(options, "anisotropy");
  o.model_tolerance = value_of_key<double>(options, "model_tolerance");
  o.fluence = value_of_key<bool>(options, "fluence");
  return o;
}

void read_light(const Options& options, forward::ForwardProblem& problem) {
  const FaceShape face = face_shape(problem.setup.shape, problem.setup.lit_face);
  problem.patterns = 0;
  if (!options["irradiance"].is_none()) {
    const auto light = numbers<double>(options["irradiance"], "irradiance");
    const int patterns = light.ndim() == 3 ? static_cast<int>(light.shape(0)) : 1;
    if (light.ndim() == 2)
      require_shape(light, {face.nv, face.nu}, "irradiance", "[v][u] of the lit face");
    else
      require_shape(light, extents(patterns, face), "irradiance", "[M][v][u] of the lit face");
    const std::span<const double> values = view(light);
    if (!std::all_of(values.begin(), values.end(),
                     [](double e) { return std::isfinite(e) && e >= 0.0; }))
      throw KeyedError("irradiance", "irradiance must be finite and not negative everywhere");
    const double brightest = values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
    require_usual("irradiance", [&] { require_usual_light(brightest, "forward"); });
    problem.irradiance = copy(light);
    problem.patterns = patterns;
  }
  for (const auto& point : options["points"].cast<std::vector<std::array<double, 4>>>()) {
    problem.light.points.push_back({{point[0], point[1], point[2]}, point[3]});
    ++problem.patterns;
  }
  if (problem.patterns == 0)
    throw KeyedError("irradiance", "there is no light; give irradiance, points or both");
  problem.irradiance.resize(static_cast<std::size_t>(problem.patterns) * face.cells());
  if (options["direction"].is_none()) return;
  if (options["irradiance"].is_none())
    throw KeyedError("direction", "direction is that of irradiance, which is missing");
  const auto d = value_of_key<std::array<double, 3>>(options, "direction");
  problem.light.direction = Eigen::Vector3d(d.data());
}

py::dict maps(std::array<std::vector<double>, 6>& faces, int patterns, const GridShape& shape) {
  py::dict found;
  for (const Face face : all_faces) {
    std::vector<double>& values = faces[static_cast<std::size_t>(face)];
    if (values.empty()) continue;
    found[to_string(face).c_str()] =
        take(std::move(values), extents(patterns, face_shape(shape, face)));
  }
  return found;
}

py::dict forward(const py::object& kappa_given, const py::object& mu_given, const Options& options,
                 const py::object& progress) {
  const auto kappa = numbers<double>(kappa_given, "kappa");
  const auto mu = numbers<double>(mu_given, "mu");
  const GridShape shape = grid_of(kappa, value_of_key<double>(options, "voxel_mm"), "kappa");
  require_shape(mu, extents(shape), "mu", "[z][y][x] of kappa");
  forward::ForwardProblem problem;
  problem.setup = setup_of(options, shape);
  problem.medium = {Volume<double>(shape, copy(kappa)), Volume<double>(shape, copy(mu))};
  require_usual("voxel_mm", [&] { require_usual_voxel(shape.voxel_mm, "voxel_mm"); });
  validate(problem.medium, "forward");
  read_light(options, problem);
  const std::string method = text(options, "method");
  const app::ForwardRun run{method, problem.setup, options_of(options), problem.patterns,
                            problem.light};
  const auto model = forward::make_forward_model(method);
  forward::ForwardResult result;
  listen(progress, [&](const std::shared_ptr<Mail>& mail) {
    MailProgress listener(mail);
    result = model->solve(problem, run.options, listener);
    for (const std::string& warning : result.warnings) listener.warn(warning);
    const auto& methods = forward::forward_methods();
    const bool transport = std::any_of(methods.begin(), methods.end(), [&](const auto& known) {
      return known.name == method && known.transport;
    });
    if (transport) return;
    const forward::Precision precision = result.backend == "reference"
                                             ? forward::Precision::double_precision
                                             : run.options.precision;
    for (const auto& warning :
         forward::diffusion_warnings(problem.setup, problem.medium, precision))
      listener.warn(warning);
  });
  py::dict found;
  found["summary"] = app::forward_summary(run, result).dump();
  found["exitance"] = maps(result.exitance, run.patterns, shape);
  found["standard_error"] = maps(result.standard_error, run.patterns, shape);
  const auto volume = [&](std::vector<double>& values) -> py::object {
    if (values.empty()) return py::none();
    return take(std::move(values), extents(run.patterns, shape));
  };
  found["fluence"] = volume(result.fluence);
  found["fluence_error"] = volume(result.fluence_error);
  return found;
}

}  // namespace

void bind_forward(py::module_& module) {
  module.def("forward", forward);
  module.def("forward_methods", [] {
    py::dict methods;
    for (const forward::MethodName& method : forward::forward_methods())
      methods[method.name.c_str()] = method.description;
    return methods;
  });
}

}  // namespace kappamu::python
