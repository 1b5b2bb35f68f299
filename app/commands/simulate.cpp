#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/light_options.h"
#include "core/error.h"
#include "data_synthetic/simulate.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct SimulateArguments {
  std::string out;
  synthetic::SimulationOptions options;
  std::string encoding = "response";
  std::string board = "chessboard";
  std::string plane_light = "chessboard";
  std::string transport = "diffusion";
  std::string camera;  ///< "WxH"
  std::string grid;    ///< "NxMxL"
  std::vector<double> exposures_s;
  std::vector<std::string> patterns;
};

/// "640x480" as numbers; throws InputError naming `option`.
template <std::size_t N>
std::array<int, N> parse_extents(const std::string& text, const std::string& option,
                                 const std::string& example) {
  const std::string wrong = option + " \"" + text + "\" is not of the form " + example;
  std::array<int, N> extents{};
  std::size_t at = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const std::size_t end = i + 1 < N ? text.find('x', at) : text.size();
    const std::string part = end == std::string::npos ? "" : text.substr(at, end - at);
    if (part.empty() || part.size() > 6 ||
        part.find_first_not_of("0123456789") != std::string::npos) {
      throw InputError(wrong);
    }
    extents[i] = std::stoi(part);
    at = end + 1;
  }
  return extents;
}

synthetic::SimulationOptions resolve(const SimulateArguments& arguments, std::uint64_t seed) {
  synthetic::SimulationOptions options = arguments.options;
  options.seed = seed;
  options.encoding =
      arguments.encoding == "linear" ? capture::Encoding::linear : capture::Encoding::response;
  options.transport = arguments.transport == "montecarlo" ? synthetic::TransportMethod::monte_carlo
                                                          : synthetic::TransportMethod::diffusion;
  for (const capture::BoardKind kind : {capture::BoardKind::charuco, capture::BoardKind::circles,
                                        capture::BoardKind::asymmetric_circles}) {
    if (arguments.board == capture::to_string(kind)) options.board = kind;
  }
  options.plane_light = capture::plane_light_from_string(arguments.plane_light);
  if (!arguments.camera.empty()) {
    options.camera_size = parse_extents<2>(arguments.camera, "--camera", "640x480");
  }
  if (!arguments.grid.empty()) {
    options.grid = parse_extents<3>(arguments.grid, "--grid", "40x32x12");
  }
  if (!arguments.exposures_s.empty()) options.exposures_s = arguments.exposures_s;
  options.pattern_files.assign(arguments.patterns.begin(), arguments.patterns.end());
  return options;
}

std::string extents(const GridShape& grid) {
  return std::to_string(grid.nx) + " x " + std::to_string(grid.ny) + " x " +
         std::to_string(grid.nz);
}

void print(const synthetic::SimulationReport& report, bool as_json) {
  double total = 0.0;
  for (const auto& [stage, seconds] : report.seconds) total += seconds;
  if (as_json) {
    const auto voxels = [](const GridShape& grid) {
      return nlohmann::json{grid.nx, grid.ny, grid.nz};
    };
    const nlohmann::json object{{"session", report.session.string()},
                                {"truth", report.truth.string()},
                                {"sample", report.sample},
                                {"grid", voxels(report.grid)},
                                {"voxel_mm", report.grid.voxel_mm},
                                {"transport_grid", voxels(report.transport_grid)},
                                {"transport_model", report.transport_model},
                                {"transport_backend", report.transport_backend},
                                {"patterns", report.patterns},
                                {"frames", report.frames},
                                {"seconds_by_stage", report.seconds},
                                {"seconds", total}};
    print_json(object);
    return;
  }
  std::printf("session   %s (%d patterns, %d frames)\n", report.session.c_str(), report.patterns,
              report.frames);
  std::printf("truth     %s\n", report.truth.c_str());
  std::printf("sample    %s, %s voxels of %g mm to fit\n", report.sample.c_str(),
              extents(report.grid).c_str(), report.grid.voxel_mm);
  std::printf("transport %s, %s cells of %g mm on %s\n", report.transport_model.c_str(),
              extents(report.transport_grid).c_str(), report.transport_grid.voxel_mm,
              report.transport_backend.c_str());
  std::printf("seconds   %.1f\n", total);
}

}  // namespace

void add_simulate(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("simulate",
                         R"(Simulate the capture of a translucent block by a projector and a camera.

Writes OUT/session, a capture session such as any rig leaves (docs/formats.md), and
OUT/truth, the ground truth for `kappamu score`: true κ, μ, optics, poses, noise-free
pictures, and the block's answer to light patches the session never shows. Light passes
through the block by grid diffusion in the physical convention with the first-collision
source, on a grid two times finer than the one to be fitted, or by Monte Carlo transport
in the same cells, whose noise is then in the truth too (docs/montecarlo.md); lenses,
vignetting, defocus, black level, response, noise and mounting errors are those of
docs/simulator.md. The pose of everything is a little off and unknown to the pipeline.)");
  auto arguments = std::make_shared<SimulateArguments>();
  SimulateArguments& a = *arguments;
  command
      ->add_option("--sample", a.options.sample,
                   "demo (40 x 32 x 12 voxels, back-lit), wax1 (130 x 53 x 37, back-lit), wax2 "
                   "(140 x 75 x 48, front-lit), marble (256 x 256 x 20, back-lit), stone "
                   "(128 x 128 x 41, back-lit), tiny (12 x 10 x 6, back-lit), phantom "
                   "(48 x 48 x 24, front-lit, homogeneous, index 1.4: for sinusoids)")
      ->type_name("NAME")
      ->capture_default_str();
  add_out(*command, a.out, "Folder to write session/ and truth/ into");
  add_fit_light(*command, a.options.light);
  command->add_flag("!--no-validation", a.options.validation,
                    "Leave out the patterns kept from the fit (4 small patches, cross, checker)");
  command->add_flag("--both-faces", a.options.both_faces,
                    "Photograph the lit face under the patterns too, from the calibration station "
                    "(in a dark room); of front-lit samples, which show no other face, from two "
                    "stations");
  command
      ->add_option("--surface-reflectance", a.options.surface_reflectance,
                   "Mean diffuse reflectance of the lit face's surface, over its scattering, 0 to "
                   "0.5; the camera is then exposed for lit pixels")
      ->type_name("SHARE")
      ->capture_default_str();
  command
      ->add_option("--pattern", a.patterns,
                   "Further pattern pictures, grey, 8 bits, 1024 x 768; not used by the fit")
      ->type_name("FILE");
  command
      ->add_option("--noise", a.options.noise_scale,
                   "Factor on shot noise (20000 electrons full scale) and read noise (5); 0: none")
      ->type_name("FACTOR")
      ->capture_default_str();
  command->add_option("--bit-depth", a.options.bit_depth, "Bits of a code value, 8 to 16")
      ->type_name("BITS")
      ->capture_default_str();
  command
      ->add_option("--encoding", a.encoding, "response (an unknown monotone curve) or linear (RAW)")
      ->check(CLI::IsMember({"response", "linear"}))
      ->capture_default_str();
  command
      ->add_option("--transport", a.transport,
                   "diffusion (converged), or montecarlo (radiative transfer, OpenCL only)")
      ->check(CLI::IsMember({"diffusion", "montecarlo"}))
      ->capture_default_str();
  command
      ->add_option("--photons", a.options.photons,
                   "Per pattern and channel, of --transport montecarlo")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--anisotropy", a.options.anisotropy,
                   "Henyey-Greenstein g of --transport montecarlo, at equal reduced scattering; "
                   "what is seen where light falls needs it")
      ->type_name("G")
      ->capture_default_str();
  command->add_option("--board", a.board, "Kind of the printed board")
      ->check(CLI::IsMember({"chessboard", "charuco", "circles", "asymmetric-circles"}))
      ->capture_default_str();
  command->add_option("--boards", a.options.board_views, "Views of the printed board, 3 to 60")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--planes", a.options.projector_planes, "Poses of the projector plane, 3 to 40")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--projector-gamma", a.options.projector_gamma,
                   "The projector's light goes as (value/255)^G")
      ->type_name("G")
      ->capture_default_str();
  command
      ->add_option("--projector-levels", a.options.projector_levels,
                   "Also shoot the white target under N values between black and white")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--room-light", a.options.room_light,
                   "Room light that cannot be switched off, over the projector's white; shoots "
                   "target and sample with the projector off too")
      ->type_name("SHARE")
      ->capture_default_str();
  command
      ->add_option("--room-change", a.options.room_change,
                   "Its relative change from the first pattern to the last")
      ->type_name("SHARE")
      ->capture_default_str();
  command
      ->add_option("--plane-light", a.plane_light,
                   "Projected on the projector's planes: chessboard, gray-code (42 frames each), "
                   "both, phase-shift (36 frames each)")
      ->check(CLI::IsMember({"chessboard", "gray-code", "both", "phase-shift"}))
      ->capture_default_str();
  command
      ->add_option("--exposures", a.exposures_s,
                   "Exposure times of each pattern in seconds, rising (six from 1/30 to 8)")
      ->type_name("SECONDS");
  command
      ->add_option("--camera", a.camera,
                   "Camera picture (demo 640x480, tiny 400x300, others 1280x960)")
      ->type_name("WxH");
  command->add_option("--grid", a.grid, "Voxels to fit, instead of the sample's own")
      ->type_name("NxMxL");
  command
      ->add_option("--holdout", a.options.holdout,
                   "n of the n x n held-out patches in the truth; 0: none, quicker")
      ->type_name("N")
      ->capture_default_str();
  command->footer(
      R"(Example:
  $ kappamu simulate --sample demo -o demo
  $ kappamu run demo/session -o demo/run
  $ kappamu score demo/run --truth demo/truth
Equal options and --seed give equal frames on one --device. Not simulated: colour wheel,
camera defocus and vignetting, inter-reflections, surface gloss, light past the block.)");
  command->callback([arguments, &globals] {
    const auto progress = make_progress();
    pipeline::require_apart(arguments->out,
                            {arguments->patterns.begin(), arguments->patterns.end()});
    print(synthetic::simulate(resolve(*arguments, globals.seed), arguments->out, globals.device,
                              *progress),
          globals.json);
  });
}

}  // namespace kappamu::app
