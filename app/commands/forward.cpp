#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/forward_input.h"
#include "app/forward_output.h"
#include "app/options/block_options.h"
#include "core/error.h"
#include "core/file_name.h"
#include "forward/diffusion_warnings.h"
#include "forward/forward_model.h"
#include "io/atomic_file.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct ForwardArguments {
  ForwardFiles files;
  std::string out;
  std::string method = "multigrid";
  BlockOptions block;
  std::string precision = "single";
  std::vector<double> direction;    ///< x, y, z or empty
  std::vector<std::string> points;  ///< "x,y,z" or "x,y,z,power" each
  std::optional<std::string> fluence;
  forward::ForwardOptions model;
};

const forward::MethodName& method_named(const std::string& name) {
  const auto& methods = forward::forward_methods();
  return *std::find_if(methods.begin(), methods.end(),
                       [&](const auto& method) { return method.name == name; });
}

forward::PointSource point_from(const std::string& text) {
  forward::PointSource point;
  int used = 0;
  const int read =
      std::sscanf(text.c_str(), "%lf,%lf,%lf%n,%lf%n", &point.position_mm.x(),
                  &point.position_mm.y(), &point.position_mm.z(), &used, &point.power, &used);
  if (read < 3 || static_cast<std::size_t>(used) != text.size()) {
    throw InputError("--point '" + shown_name(text) +
                     "' is not x,y,z in mm, or x,y,z,power; write for example --point 5,5,2.5");
  }
  return point;
}

/// Irradiance first, then each point as a pattern of its own.
void read_light(const ForwardArguments& arguments, forward::ForwardProblem& problem) {
  const GridShape& shape = problem.setup.shape;
  const Face lit_face = problem.setup.lit_face;
  Irradiance light = read_irradiance(arguments.files, shape, lit_face);
  problem.irradiance = std::move(light.values);
  for (const std::string& text : arguments.points) problem.light.points.push_back(point_from(text));
  problem.patterns = light.patterns + static_cast<int>(problem.light.points.size());
  if (problem.patterns == 0)
    throw InputError("there is no light; give --irradiance, --point or both");
  problem.irradiance.resize(static_cast<std::size_t>(problem.patterns) *
                            face_shape(shape, lit_face).cells());
  if (arguments.direction.empty()) return;
  if (light.patterns == 0)
    throw InputError("--direction is that of --irradiance, which is missing");
  problem.light.direction = Eigen::Vector3d(arguments.direction.data());
}

void run_forward(const ForwardArguments& arguments, Globals& globals) {
  const auto progress = make_progress();
  const forward::MethodName& method = method_named(arguments.method);
  forward::ForwardProblem problem;
  problem.medium = read_medium(arguments.files);
  problem.setup = arguments.block.setup(problem.medium.kappa.shape());
  const GridShape& shape = problem.setup.shape;
  read_light(arguments, problem);

  ForwardRun run{method.name, problem.setup, arguments.model, problem.patterns, problem.light};
  run.options.fluence = arguments.fluence.has_value();
  run.options.device = globals.device;
  run.options.seed = globals.seed;
  run.options.precision = arguments.precision == "double" ? forward::Precision::double_precision
                                                          : forward::Precision::single_precision;
  const ForwardFiles& files = arguments.files;
  std::vector<std::filesystem::path> inputs{files.kappa, files.mu};
  if (!files.irradiance.empty()) inputs.emplace_back(files.irradiance);
  pipeline::OutputFolder out(arguments.out, "forward", inputs, forward_outputs());
  const forward::ForwardResult result =
      forward::make_forward_model(method.name)->solve(problem, run.options, *progress);

  write_maps(out.partial(), run, result);
  if (arguments.fluence) {
    write_fluence(out.partial(),
                  *arguments.fluence == "vti"   ? FluenceFormat::vti
                  : *arguments.fluence == "vdb" ? FluenceFormat::vdb
                                                : FluenceFormat::npy,
                  run, result);
  }
  const nlohmann::ordered_json summary = forward_summary(run, result);
  io::write_text_atomically(out.partial() / "summary.json", summary.dump(2) + "\n");
  out.commit();
  // Only now, so that a failure is one sentence and nothing else.
  std::vector<std::string> warnings = result.warnings;
  if (!method.transport) {
    const forward::Precision precision = result.backend == "reference"
                                             ? forward::Precision::double_precision
                                             : run.options.precision;
    const auto more = forward::diffusion_warnings(problem.setup, problem.medium, precision);
    warnings.insert(warnings.end(), more.begin(), more.end());
  }
  for (const auto& warning : warnings) progress->warn(warning);

  if (result.termination != forward::Termination::converged) {
    progress->warn("not converged: " + result.message + "; the outputs are kept and marked");
    globals.exit_code = 3;
  }
  if (globals.json) {
    print_json(summary);
  } else {
    std::printf("%d pattern%s on %d x %d x %d voxels by %s, %s: %s, %.2f s\n%s\n", run.patterns,
                run.patterns == 1 ? "" : "s", shape.nx, shape.ny, shape.nz, run.method.c_str(),
                result.backend.c_str(), result.message.c_str(), result.seconds,
                (std::filesystem::path(arguments.out) / "summary.json").c_str());
  }
}

constexpr const char* manual =
    R"(Predict the light that leaves a block of known coefficients under given light.

  kappamu forward --kappa k.npy --mu m.npy --voxel 0.25 --eta 1.3 \
                  --irradiance e.npy --lit-face z- -o out/

Solves the diffusion equation div(kappa grad phi) - mu phi + S = 0 with Fresnel (Robin)
boundaries by conservative finite volumes on the voxels given, all patterns at once; other
models and solvers under METHODS.

INPUT, float arrays in C order, the last axis varying fastest:
  kappa       [z][y][x]  diffusion coefficient 1/(3(mu + sigma_s')) [mm], > 0
  mu          [z][y][x]  absorption coefficient [1/mm], >= 0
  irradiance  [M][v][u]  incident on the lit face before Fresnel, one map per pattern, any
              unit: [y][x] on z faces, [z][x] on y faces, [z][y] on x faces; [v][u] is M = 1
kappa and mu may be .vdb files (grids kappa_R, mu_R, ...; --channel R), which bring their
voxel edge along.

OUTPUT in the folder of -o:
  exitance_x-.npy ... exitance_z+.npy  [M][v][u] flux per area leaving each face, in the
              unit of the irradiance; mean over each surface voxel; unscattered light and
              the specular reflection are not in it
  standard_error_<face>.npy  of the exitance, the same shapes (montecarlo only)
  fluence.npy [M][z][y][x], or fluence.vti or .vdb (volumes phi_0, phi_1, ...), with
              --fluence: the fluence rate phi of scattered light, and of all light of a point, mean over each
              voxel, in the unit of the irradiance; of montecarlo with standard_error_fluence.npy
  summary.json  per pattern: power entering (after Fresnel), exiting by face, unscattered,
              absorbed [mm^2 times the unit of irradiance], residual; iterations, seconds

SOURCES. first-collision (default): a collimated beam at normal incidence deposits its first
collisions along the columns below the lit face, reflected to and fro between that and the far
face, which suits projectors. boundary: light
enters diffusely at the face, which suits diffuse illumination.
With --direction the beam falls in obliquely: it is refracted at the face, deposits its first
collisions along its way, and is reflected and refracted at every face that it meets. Each
--point is one more pattern, after those of the irradiance: a source inside the block that
radiates evenly in all directions, of power 1 or as given [mm^2 times the unit of irradiance].

CONVENTIONS. physical (default): coefficients comparable with published ones. wang2008: the
equations of Wang et al. 2008 as printed (C = 2.1489, q = E_t, source boundary); the maps
then hold pi times their radiance, negative where light enters, and do not balance.)";

constexpr const char* manual_end =
    R"(Exit codes: 0 done, 1 bad input (one sentence), 2 usage, 3 tolerance not met (outputs kept;
summary.json says "converged": false).

WHEN NOT TO TRUST IT. Diffusion fails where mu is not far below sigma_s', within a few
transport mean free paths (3 kappa) of beam edges, in thinner blocks and in voids; the
program warns of the first two. The grid adds its own error, of order voxel^2: split the
voxels and compare. On the lit face under the boundary source the order is 1 to 1.5.)";

std::string methods_manual() {
  std::string text = "METHODS of --method:\n";
  for (const auto& method : forward::forward_methods()) {
    const std::string padding(
        std::max<std::size_t>(18, method.name.size() + 1) - method.name.size(), ' ');
    text += "  " + method.name + padding + method.description + "\n";
  }
  return text +
         R"(multigrid is the one to use; analytic and montecarlo are its references. auto decides between
multigrid and montecarlo by errors measured on other blocks (docs/objects-bench.md); the
message of summary.json names the one taken and why. Only montecarlo and analytic need no
convergence.

)";
}

}  // namespace

void add_forward(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("forward", manual);
  auto options = std::make_shared<ForwardArguments>();
  ForwardFiles& files = options->files;
  command->add_option("--kappa", files.kappa, "Diffusion coefficient [mm], .npy or .vdb")
      ->required()
      ->type_name("FILE");
  command->add_option("--mu", files.mu, "Absorption coefficient [1/mm], .npy or .vdb")
      ->required()
      ->type_name("FILE");
  command->add_option("--irradiance", files.irradiance, "Light on the lit face, .npy")
      ->type_name("FILE");
  command
      ->add_option("--direction", options->direction,
                   "Direction in air in which the light of --irradiance travels (default: normal "
                   "to the lit face); irradiance is per area of the face")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command
      ->add_option("--point", options->points,
                   "Isotropic source inside the block [mm]; may be given several times")
      ->type_name("X,Y,Z[,POWER]");
  command
      ->add_option("--fluence", options->fluence,
                   "Also write the fluence rate in the block, as npy, vti (ParaView) or vdb")
      ->check(CLI::IsMember({"npy", "vti", "vdb"}));
  add_out(*command, options->out, "Folder for the maps; made if missing");
  command->add_option("--voxel", files.voxel, "Voxel edge [mm]; needed with .npy volumes")
      ->check(positive_number);
  command->add_option("--channel", files.channel, "Channel of a .vdb with several, such as R");
  add_most_voxels(*command, files.most_voxels);
  std::vector<std::string> methods;
  for (const auto& method : forward::forward_methods()) methods.push_back(method.name);
  command->add_option("--method", options->method, "Default multigrid; see METHODS below")
      ->check(CLI::IsMember(methods))
      ->type_name("NAME");
  add_block_options(*command, options->block, options->model.solve);
  command->add_option("--precision", options->precision, "single (default) or double storage")
      ->check(CLI::IsMember({"single", "double"}));
  command
      ->add_option("--photons", options->model.photons,
                   "montecarlo: photons per pattern, auto: at most (default 1000000)")
      ->check(positive_number);
  command
      ->add_option("--anisotropy", options->model.anisotropy,
                   "montecarlo: g of the phase function at equal sigma_s' (default 0)")
      ->check(CLI::Range(-0.999, 0.999));
  command
      ->add_option("--model-tolerance", options->model.model_tolerance,
                   "auto: relative error against transport, 2-norm over the faces (default 0.05)")
      ->check(CLI::Range(1e-4, 0.9));
  command->footer(methods_manual() + manual_end);
  command->callback([options, &globals] { run_forward(*options, globals); });
}

}  // namespace kappamu::app
