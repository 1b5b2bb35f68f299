#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/photograph_options.h"
#include "app/session_command.h"
#include "calib/calibration_file.h"
#include "core/error.h"
#include "pipeline/output_folder.h"
#include "pipeline/pipeline.h"
#include "pipeline/stages/photographs.h"

namespace kappamu::app {

namespace {

struct PhotographCommand {
  PhotographOptions photographs;
  std::optional<std::string> held, start;  ///< files of known lenses

  std::optional<calib::KnownLens> known_lens() const {
    if (held) return calib::read_known_lens(*held, calib::LensUse::held);
    if (start) return calib::read_known_lens(*start, calib::LensUse::start);
    return std::nullopt;
  }
  BoardOptions board;
};

nlohmann::json lens_json(const calib::Lens& lens, double rms_px, const std::string& model) {
  return {{"fx", lens.fx},
          {"fy", lens.fy},
          {"cx", lens.cx},
          {"cy", lens.cy},
          {"distortion", lens.distortion},
          {"model", model},
          {"rms_px", rms_px}};
}

void print_lens(const char* name, const calib::Lens& lens, double rms_px,
                const std::string& model) {
  std::printf("%-10s fx %.2f fy %.2f cx %.2f cy %.2f px  reprojection RMS %.3f px  (%s)\n", name,
              lens.fx, lens.fy, lens.cx, lens.cy, rms_px, model.c_str());
}

void calibrate_lenses(const SessionCommand& options, const PhotographCommand& photographs,
                      const Globals& globals) {
  const auto progress = make_progress();
  pipeline::OutputFolder out(options.run, "calibrate", {options.session},
                             {"camera.yml", "projector.yml", "calibration.json"});
  const calib::CalibrationResult result = pipeline::calibrate_photographs(
      photographs.photographs.source(options.session, options.links), photographs.board.board(),
      photographs.board.projector_size(), photographs.known_lens(), out.partial(), *progress);
  out.commit();
  const bool projected = !result.projector.views.empty();
  const auto& deviations = result.camera_uncertainty.deviation_px;
  const double middle_px = deviations[deviations.size() / 2];
  const double worst_px = *std::max_element(deviations.begin(), deviations.end());
  if (globals.json) {
    nlohmann::json object{{"calibration", out.path().string()},
                          {"camera", lens_json(result.camera.lens, result.camera.rms_px,
                                               to_string(result.camera.model))},
                          {"camera_deviation_px", middle_px},
                          {"camera_largest_deviation_px", worst_px},
                          {"views", result.camera.views.size()},
                          {"projector", nullptr},
                          {"warnings", result.warnings}};
    if (projected) {
      object["projector"] = lens_json(result.projector.lens, result.projector.rms_px,
                                      to_string(result.projector.model));
    }
    print_json(object);
    return;
  }
  print_lens("camera", result.camera.lens, result.camera.rms_px, to_string(result.camera.model));
  if (projected) {
    print_lens("projector", result.projector.lens, result.projector.rms_px,
               to_string(result.projector.model));
  }
  std::printf("%zu views; a point at the boards' distance +- %.3f px, %.3f px where least known\n",
              result.camera.views.size(), middle_px, worst_px);
  std::printf("%s\n", out.path().c_str());
}

void run_calibrate(const SessionCommand& options, const PhotographCommand& photographs,
                   const Globals& globals) {
  if (!photographs.board.corners.empty()) return calibrate_lenses(options, photographs, globals);
  if (photographs.held || photographs.start) {
    throw InputError(
        "--lens and --lens-start are of photographs without a session (--board); a session's known "
        "lens is calibration.lens of its session.json (docs/formats.md).");
  }
  photographs.photographs.require_none(options.session);
  const auto progress = make_progress();
  pipeline::Pipeline stages(options.session, options.run,
                            {.replace_other_run = options.force, .links = options.links});
  stages.set_hdr_options(options.hdr);
  const bool worked = stages.calibrate(*progress);
  const calib::CalibrationResult found =
      calib::load_calibration(stages.folder().path() / "calibration");
  const double camera = found.camera.rms_px, projector = found.projector.rms_px;
  const std::string camera_model = to_string(found.camera.model);
  const std::string projector_model = to_string(found.projector.model);
  const auto& deviations = found.camera_uncertainty.deviation_px;
  const double worst_px = *std::max_element(deviations.begin(), deviations.end());
  const double middle_px = deviations[deviations.size() / 2];
  const calib::PoseUncertainty pose =
      calib::pose_uncertainty(found.pattern_pose, Eigen::Vector3d::Zero());
  const std::string folder = (stages.folder().path() / "calibration").string();
  const double seconds = stages.folder().record().stages.at("calibrate").seconds;
  if (globals.json) {
    print_json({{"calibration", folder},
                {"camera_rms_px", camera},
                {"projector_rms_px", projector},
                {"camera_model", camera_model},
                {"projector_model", projector_model},
                {"camera_deviation_px", middle_px},
                {"camera_largest_deviation_px", worst_px},
                {"sample_deviation_mm", {pose.place_mm.x(), pose.place_mm.y(), pose.place_mm.z()}},
                {"sample_deviation_degrees", pose.turn_degrees},
                {"warnings", found.warnings},
                {"seconds", seconds}});
    return;
  }
  std::printf("camera reprojection RMS     %.3f px  (%s)\n", camera, camera_model.c_str());
  std::printf("projector reprojection RMS  %.3f px  (%s)\n", projector, projector_model.c_str());
  std::printf("camera at the sample        +- %.3f px, %.3f px where it is known least\n",
              middle_px, worst_px);
  std::printf("sample's first corner       +- %.3f, %.3f, %.3f mm, turn +- %.3f degrees\n",
              pose.place_mm.x(), pose.place_mm.y(), pose.place_mm.z(), pose.turn_degrees);
  std::printf("%s  (%s)\n", folder.c_str(),
              time_taken(worked ? std::optional(seconds) : std::nullopt).c_str());
}

}  // namespace

void add_calibrate(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "calibrate",
      R"(Calibrate camera, projector, sample pose and radiometry from a session's own shots.

Writes RUN/calibration: camera.yml and projector.yml (OpenCV's model, with covariance),
pose.yml, response.yml, radiometry.yml and calibration.json (residuals by view).
The reprojection RMS is the distance [px] between found corners and where the fitted model
puts them. Below 0.3 px is good; above 1 px, look for a blurred or misread board: the report
shows the residuals of every view. A low RMS says nothing about parts of the picture that no
board reached: that is what the deviation (one standard deviation, px) tells, at the
sample's distance, in the middle of the picture and where it is largest. The sample's place
is that of its first corner along the camera's x, y, z at the pattern station.

With --board, SESSION is a folder of photographs of that board and nothing else is needed:
into RUN go camera.yml and calibration.json. With --projector, photographs named
plane_<n>_board and plane_<n>_gray_<k> (or listed so in --table) give projector.yml, too.
The lens is that of the pictures as they are stored, or as --orientation apply turns them.
Circle grids may be dark on light or light on dark; of ChArUco boards both layouts are read,
OpenCV's and the one before its version 4.6. docs/howto/one-stage.md.)");
  const auto options = add_session_options(*command);
  auto photographs = std::make_shared<PhotographCommand>();
  add_board_options(*command, photographs->board);
  add_photograph_options(*command, photographs->photographs);
  auto* held = command
                   ->add_option("--lens", photographs->held,
                                "The camera's lens, known and held as it is: camera_matrix and "
                                "distortion_coefficients in YAML or JSON; with --board")
                   ->type_name("FILE");
  command
      ->add_option("--lens-start", photographs->start,
                   "The same as a start of the calibration, where it finds none by itself")
      ->type_name("FILE")
      ->excludes(held);
  command->footer(
      "Examples: kappamu calibrate demo/session -o demo/run\n"
      "          kappamu calibrate boards -o camera --board 9x6 --square 25");
  command->callback(
      [options, photographs, &globals] { run_calibrate(*options, *photographs, globals); });
}

}  // namespace kappamu::app
