#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "app/command.h"
#include "app/forward_input.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/power_balance.h"
#include "io/atomic_file.h"
#include "io/npy.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;
using forward::Convention;
using forward::Precision;
using forward::SourceModel;

struct ForwardOptions {
  ForwardFiles files;
  std::string out;
  double eta = 1.3;
  std::string lit_face = "z-";
  std::string sides = "open";
  std::optional<std::string> source;
  std::string convention = "physical";
  std::string precision = "single";
  forward::SolveOptions solve;
};

forward::GridSetup setup_of(const ForwardOptions& options, const GridShape& shape) {
  forward::GridSetup setup;
  setup.shape = shape;
  setup.eta = options.eta;
  setup.lit_face = face_from_string(options.lit_face);
  setup.sides = sides_from_string(options.sides);
  setup.convention = options.convention == "wang2008" ? Convention::wang2008 : Convention::physical;
  // wang2008 has one source only, so it is the default there.
  const std::string source = options.source.value_or(
      setup.convention == Convention::wang2008 ? "boundary" : "first-collision");
  setup.source = source == "boundary" ? SourceModel::boundary : SourceModel::first_collision;
  return setup;
}

Json summary_of(const forward::GridSolver& solver, const forward::SolveReport& report,
                const std::vector<forward::PowerBalance>& balances, const ForwardOptions& options) {
  const forward::GridSetup& setup = solver.setup();
  const GridShape& s = setup.shape;
  Json patterns = Json::array();
  for (std::size_t m = 0; m < balances.size(); ++m) {
    Json exiting;
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      exiting[to_string(all_faces[f])] = balances[m].exiting[f];
    }
    patterns.push_back({{"entering", balances[m].entering},
                        {"exiting", exiting},
                        {"unscattered", balances[m].unscattered},
                        {"absorbed", balances[m].absorbed},
                        {"residual", report.residual[m]}});
  }
  const bool first_collision = setup.source == SourceModel::first_collision;
  return {{"converged", report.termination == forward::Termination::converged},
          {"message", report.message},
          {"iterations", report.iterations},
          {"residual", *std::max_element(report.residual.begin(), report.residual.end())},
          {"tolerance", options.solve.tolerance},
          {"seconds", report.seconds},
          {"backend", solver.backend()},
          {"grid", {s.nx, s.ny, s.nz}},
          {"voxel_mm", s.voxel_mm},
          {"eta", setup.eta},
          {"A", solver.constants().A},
          {"normal_transmittance", solver.constants().normal_transmittance},
          {"lit_face", to_string(setup.lit_face)},
          {"sides", to_string(setup.sides)},
          {"source", first_collision ? "first-collision" : "boundary"},
          {"convention", options.convention},
          {"units", {{"power", "mm^2 times the unit of irradiance"}, {"length", "mm"}}},
          {"patterns", patterns}};
}

void run_forward(const ForwardOptions& options, Globals& globals) {
  const auto progress = make_progress();
  const Medium medium = read_medium(options.files);
  const forward::GridSetup setup = setup_of(options, medium.kappa.shape());
  const Irradiance light = read_irradiance(options.files, setup.shape, setup.lit_face);
  const Precision precision =
      options.precision == "double" ? Precision::double_precision : Precision::single_precision;
  const forward::SolverChoice choice = forward::make_grid_solver(setup, globals.device, precision);
  if (!choice.warning.empty()) progress->warn(choice.warning);
  for (const auto& warning : forward::diffusion_warnings(setup, medium)) progress->warn(warning);

  forward::GridSolver& solver = *choice.solver;
  solver.set_medium(medium.kappa.values(), medium.mu.values());
  const auto b = solver.make_field(light.patterns);
  const auto phi = solver.make_field(light.patterns);
  solver.light_source(light.values, *b);
  const forward::SolveReport report = solver.solve(*b, *phi, options.solve);

  const std::filesystem::path out(options.out);
  const auto patterns = static_cast<std::size_t>(light.patterns);
  std::array<std::vector<double>, 6> maps;
  for (std::size_t f = 0; f < all_faces.size(); ++f) {
    const FaceShape face = face_shape(setup.shape, all_faces[f]);
    maps[f].resize(face.cells() * patterns);
    solver.exitance(*phi, all_faces[f],
                    all_faces[f] == setup.lit_face ? std::span<const double>(light.values)
                                                   : std::span<const double>(),
                    maps[f]);
    const std::vector<float> stored(maps[f].begin(), maps[f].end());
    io::write_npy(out / ("exitance_" + to_string(all_faces[f]) + ".npy"),
                  {patterns, static_cast<std::size_t>(face.nv), static_cast<std::size_t>(face.nu)},
                  std::span<const float>(stored));
  }
  const auto balances = forward::power_balance(solver, medium, *phi, light.values, maps);
  const Json summary = summary_of(solver, report, balances, options);
  io::write_text_atomically(out / "summary.json", summary.dump(2) + "\n");

  if (report.termination != forward::Termination::converged) {
    progress->warn("not converged: " + report.message + "; the outputs are kept and marked");
    globals.exit_code = 3;
  }
  if (globals.json) {
    std::printf("%s\n", summary.dump().c_str());
  } else {
    std::printf("%d pattern%s on %d x %d x %d voxels by %s: %s, %.2f s\n%s\n", light.patterns,
                light.patterns == 1 ? "" : "s", setup.shape.nx, setup.shape.ny, setup.shape.nz,
                solver.backend().c_str(), report.message.c_str(), report.seconds,
                (out / "summary.json").c_str());
  }
}

constexpr const char* manual =
    "Predict the light that leaves a block of known coefficients under given light.\n\n"
    "  kappamu forward --kappa k.npy --mu m.npy --voxel 0.25 --eta 1.3 \\\n"
    "                  --irradiance e.npy --lit-face z- -o out/\n\n"
    "Solves the diffusion equation div(kappa grad phi) - mu phi + S = 0 with Fresnel (Robin)\n"
    "boundaries by conservative finite volumes on the voxels given, all patterns at once.\n\n"
    "INPUT, float arrays in C order, the last axis varying fastest:\n"
    "  kappa       [z][y][x]  diffusion coefficient 1/(3(mu + sigma_s')) [mm], > 0\n"
    "  mu          [z][y][x]  absorption coefficient [1/mm], >= 0\n"
    "  irradiance  [M][v][u]  incident on the lit face before Fresnel, one map per pattern, any\n"
    "              unit: [y][x] on z faces, [z][x] on y faces, [z][y] on x faces; [v][u] is M = 1\n"
    "kappa and mu may be .vdb files (grids kappa_R, mu_R, ...; --channel R), which bring their\n"
    "voxel edge along.\n\n"
    "OUTPUT in the folder of -o:\n"
    "  exitance_x-.npy ... exitance_z+.npy  [M][v][u] flux per area leaving each face, in the\n"
    "              unit of the irradiance; mean over each surface voxel; unscattered light and\n"
    "              the specular reflection are not in it\n"
    "  summary.json  per pattern: power entering (after Fresnel), exiting by face, unscattered,\n"
    "              absorbed [mm^2 times the unit of irradiance], residual; iterations, seconds\n\n"
    "SOURCES. first-collision (default): a collimated beam at normal incidence deposits its first\n"
    "collisions along the columns below the lit face, which suits projectors. boundary: light\n"
    "enters diffusely at the face, which suits diffuse illumination.\n\n"
    "CONVENTIONS. physical (default): coefficients comparable with published ones. wang2008: the\n"
    "equations of Wang et al. 2008 as printed (C = 2.1489, q = E_t, source boundary); the maps\n"
    "then hold pi times their radiance, negative where light enters, and do not balance.";

constexpr const char* manual_end =
    "Exit codes: 0 done, 1 bad input (one sentence), 2 usage, 3 tolerance not met (outputs kept;\n"
    "summary.json says \"converged\": false).\n\n"
    "WHEN NOT TO TRUST IT. Diffusion fails where mu is not far below sigma_s', within a few\n"
    "transport mean free paths (3 kappa) of beam edges, in thinner blocks and in voids; the\n"
    "program warns of the first two. The grid adds its own error, of order voxel^2: split the\n"
    "voxels and compare. On the lit face under the boundary source the order is 1 to 1.5.";

}  // namespace

void add_forward(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("forward", manual);
  auto options = std::make_shared<ForwardOptions>();
  ForwardFiles& files = options->files;
  command->add_option("--kappa", files.kappa, "Diffusion coefficient [mm], .npy or .vdb")
      ->required()
      ->type_name("FILE");
  command->add_option("--mu", files.mu, "Absorption coefficient [1/mm], .npy or .vdb")
      ->required()
      ->type_name("FILE");
  command->add_option("--irradiance", files.irradiance, "Light on the lit face, .npy")
      ->required()
      ->type_name("FILE");
  command->add_option("-o,--out", options->out, "Folder for the maps; made if missing")
      ->required()
      ->type_name("OUT");
  command->add_option("--voxel", files.voxel, "Voxel edge [mm]; needed with .npy volumes")
      ->check(CLI::PositiveNumber);
  command->add_option("--channel", files.channel, "Channel of a .vdb with several, such as R");
  command->add_option("--eta", options->eta, "Relative refractive index (default 1.3)");
  const std::vector<std::string> faces{"x-", "x+", "y-", "y+", "z-", "z+"};
  command->add_option("--lit-face", options->lit_face, "Where light enters (default z-)")
      ->check(CLI::IsMember(faces))
      ->type_name("FACE");
  command
      ->add_option("--sides", options->sides,
                   "open (default): Robin on the four faces beside the lit one; mirror: no flux")
      ->check(CLI::IsMember({"open", "mirror"}));
  command->add_option("--source", options->source, "first-collision (default) or boundary")
      ->check(CLI::IsMember({"first-collision", "boundary"}));
  command->add_option("--convention", options->convention, "physical (default) or wang2008")
      ->check(CLI::IsMember({"physical", "wang2008"}));
  command
      ->add_option("--tolerance", options->solve.tolerance,
                   "Relative residual to reach for every pattern (default 1e-6)")
      ->check(CLI::Range(1e-14, 0.1));
  command->add_option("--max-iterations", options->solve.max_iterations, "Default 200")
      ->check(CLI::Range(1, 100000));
  command->add_option("--precision", options->precision, "single (default) or double storage")
      ->check(CLI::IsMember({"single", "double"}));
  command->footer(manual_end);
  command->callback([options, &globals] { run_forward(*options, globals); });
}

}  // namespace kappamu::app
