#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/light_options.h"
#include "capture/rig/plan.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct PlanArguments {
  capture::PlanRequest request;
  std::vector<double> size_mm;
  double voxel_mm = 0.5;
  double refresh_hz = 60.0;
  std::string setup = "back-lit";
  std::string encoding = "linear";
  std::string plane_light = "chessboard";
  std::string out;
};

void run_plan(PlanArguments arguments, const Globals& globals) {
  capture::PlanRequest& request = arguments.request;
  capture::Sample& sample = request.sample;
  sample.voxel_mm = arguments.voxel_mm;
  std::vector<std::string> warnings;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = arguments.size_mm[axis];
    sample.grid[axis] = std::max(1, static_cast<int>(std::lround(size / arguments.voxel_mm)));
    const double planned = sample.grid[axis] * arguments.voxel_mm;
    if (std::abs(planned - size) <= 1e-6 * size) continue;
    char text[200];
    std::snprintf(
        text, sizeof text,
        "the block's %g mm along %c are no whole number of voxels of %g mm: it is planned "
        "as %g mm; give --voxel an edge that divides the size",
        size, "xyz"[axis], arguments.voxel_mm, planned);
    warnings.emplace_back(text);
  }
  request.setup =
      arguments.setup == "back-lit" ? capture::Setup::back_lit : capture::Setup::front_lit;
  sample.seen_face = request.setup == capture::Setup::back_lit ? Face::z_plus : Face::z_minus;
  request.camera.encoding =
      arguments.encoding == "linear" ? capture::Encoding::linear : capture::Encoding::response;
  request.plane_light = capture::plane_light_from_string(arguments.plane_light);
  request.period_s = 1.0 / arguments.refresh_hz;
  pipeline::OutputFolder out(arguments.out, "plan", {},
                             {"session.json", "patterns", "calibration", "frames", "shots.txt",
                              "shots.csv", "shots.json", "board.pdf", "rig.svg"});
  const capture::Plan plan = capture::make_plan(request, out.partial());
  capture::write_plan(plan);
  out.commit();
  const auto progress = make_progress();
  for (const std::string& warning : warnings) progress->warn(warning);
  if (globals.json) {
    print_json({{"plan", arguments.out},
                {"photographs", plan.shots.size()},
                {"patterns", plan.session.patterns.size()},
                {"grid", sample.grid},
                {"exposures_s", plan.capture.exposures_s},
                {"disk_bytes", plan.disk_bytes},
                {"exposing_s", plan.exposing_s},
                {"working_s", plan.working_s},
                {"warnings", warnings}});
    return;
  }
  std::printf("grid          %d x %d x %d voxels of %g mm\n", sample.grid[0], sample.grid[1],
              sample.grid[2], sample.voxel_mm);
  std::printf("exposures    ");
  for (std::size_t i = 0; i < plan.capture.exposures_s.size();
       i += static_cast<std::size_t>(request.repeats)) {
    std::printf(" %.4g s", plan.capture.exposures_s[i]);
  }
  if (request.repeats > 1) std::printf(", %d times each", request.repeats);
  std::printf("\nphotographs   %zu of %zu patterns, %d boards, %d planes and targets\n",
              plan.shots.size(), plan.session.patterns.size(), request.boards, request.planes);
  std::printf("disk          %.2g GB at most\n", plan.disk_bytes / 1e9);
  std::printf("time          %.0f min, of which %.0f min exposing\n", plan.working_s / 60.0,
              plan.exposing_s / 60.0);
  for (const char* file : {"rig.svg", "board.pdf", "shots.txt"}) {
    std::printf("%s/%s\n", arguments.out.c_str(), file);
  }
}

}  // namespace

void add_plan(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("plan",
                         R"(Plan a capture: what to photograph, how long, in which order.

Writes PLAN: session.json as it will be, patterns/ and calibration/ with the projector's
images, board.pdf to print, rig.svg (where things stand), and the shot list as shots.txt
(to follow by hand), shots.csv and shots.json (for a script). Exposure times are multiples
of the projector's period, since others catch part of a colour wheel's turn, and at least
1/30 s.

Save the photographs under the names listed and `kappamu run PLAN` works; where the camera
names and formats them itself, `kappamu import FOLDER --plan PLAN -o SESSION` sorts them.
The patterns assume that the lit face is centred in the projector's picture, its x axis
along the picture's; they reach half a face beyond it. Time: 2 s per photograph and 30 s
per new arrangement besides the exposures. Disk: 16-bit RGB uncompressed.)");
  auto arguments = std::make_shared<PlanArguments>();
  PlanArguments& a = *arguments;
  capture::PlanRequest& request = a.request;
  request.sample.name = "sample";
  request.camera.bit_depth = 12;
  const auto option = [&](const char* name, auto& value, const char* text) {
    return command->add_option(name, value, text)->capture_default_str();
  };
  command->add_option("--size", a.size_mm, "Block along x, y, z [mm]; z is along the light")
      ->required()
      ->expected(3)
      ->check(positive_number);
  command
      ->add_option("--projector-px-per-mm", request.projector_px_per_mm,
                   "Projector pixels per mm in the plane of the lit face")
      ->required()
      ->check(positive_number);
  command->add_option("--camera-width", request.camera.width, "[px]")->required();
  command->add_option("--camera-height", request.camera.height, "[px]")->required();
  command->add_option("--projector-width", request.projector.width, "[px]")->required();
  command->add_option("--projector-height", request.projector.height, "[px]")->required();
  add_out(*command, a.out, "Folder of the plan", "PLAN");
  option("--name", request.sample.name, "Of the sample");
  option("--voxel", a.voxel_mm, "Edge of a voxel [mm]")->check(positive_number);
  option("--eta", request.sample.eta, "Refractive index of the sample");
  option("--setup", a.setup, "back-lit or front-lit")
      ->check(CLI::IsMember({"back-lit", "front-lit"}));
  option("--bit-depth", request.camera.bit_depth, "Bits of a code value, 8 to 16");
  option("--encoding", a.encoding, "linear (RAW), or response: behind an unknown curve (JPEG)")
      ->check(CLI::IsMember({"linear", "response"}));
  option("--refresh-hz", a.refresh_hz, "Projector's refresh, or turns of its colour wheel [1/s]")
      ->check(positive_number);
  option("--longest", request.longest_s, "Longest exposure [s]")->check(positive_number);
  option("--exposures", request.exposures,
         "Per pattern; 3 leave kappa uncertain by 0.9 %, 5 by 0.5 % (docs/hdr.md)")
      ->check(CLI::Range(1, 20));
  option("--repeats", request.repeats,
         "Photographs of each exposure, which are averaged: N leave 1/N of the noise's variance")
      ->check(CLI::Range(1, 100));
  add_fit_light(*command, request.light);
  option("--validate-patches", request.validate_patches,
         "Patterns kept out of the fit: n x n patches of the lit face")
      ->check(CLI::Range(0, 100));
  option("--boards", request.boards,
         "Views of the printed board; 3 to 6 with 3 planes left kappa 5 % off, 10 with 4 and more "
         "about 1 % (docs/calibration.md)")
      ->check(CLI::Range(1, 1000));
  option("--planes", request.planes, "Poses of the projector plane")->check(CLI::Range(1, 1000));
  option("--plane-light", a.plane_light,
         "Projected on them: chessboard, gray-code (42 pictures each at 1024 x 768), both, "
         "phase-shift (36 pictures)")
      ->check(CLI::IsMember({"chessboard", "gray-code", "both", "phase-shift"}));
  option("--projector-levels", request.projector_levels,
         "Values between black and white on the white target, where patterns have such values")
      ->check(CLI::Range(0, 254));
  command->add_flag("--room-light", request.ambient,
                    "The room cannot be darkened: photograph target and sample with the "
                    "projector's lens capped too");
  option("--board-columns", request.board.columns, "Inner corners of the printed board along x");
  option("--board-rows", request.board.rows, "The same along y");
  option("--board-square", request.board.square_mm, "Edge of its squares [mm]");
  option("--white-reflectance", request.white_reflectance, "Of the white target");
  command->footer(
      "Example: kappamu plan --size 20 16 6 --projector-px-per-mm 20 --camera-width 1600 "
      "--camera-height 1200 --projector-width 1024 --projector-height 768 -o plan");
  command->callback([arguments, &globals] { run_plan(*arguments, globals); });
}

}  // namespace kappamu::app
