#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/photograph_options.h"
#include "app/session_command.h"
#include "pipeline/output_folder.h"
#include "pipeline/pipeline.h"
#include "pipeline/stages/photographs.h"
#include "report/read/run_data.h"

namespace kappamu::app {

namespace {

struct PhotographCommand {
  std::optional<std::string> table;
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
      {options.session, photographs.table, options.follow_links}, photographs.board.board(),
      photographs.board.projector_size(), out.partial(), *progress);
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
    std::printf("%s\n", object.dump().c_str());
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
  const auto progress = make_progress();
  pipeline::Pipeline stages(
      options.session, options.run,
      {.replace_other_run = options.force, .follow_links = options.follow_links});
  stages.set_hdr_options(options.hdr);
  const bool worked = stages.calibrate(*progress);
  const auto data = report::read_calibration(stages.folder().path());
  const double camera = data->camera.rms_px, projector = data->projector.rms_px;
  const auto& deviations = data->uncertainty.deviation_px;
  const double worst_px = *std::max_element(deviations.begin(), deviations.end());
  const double middle_px = deviations[deviations.size() / 2];
  const calib::PoseUncertainty pose =
      calib::pose_uncertainty(data->poses.back(), Eigen::Vector3d::Zero());
  const std::string folder = (stages.folder().path() / "calibration").string();
  const double seconds = stages.folder().record().stages.at("calibrate").seconds;
  if (globals.json) {
    std::printf("%s\n", nlohmann::json{{"calibration", folder},
                                       {"camera_rms_px", camera},
                                       {"projector_rms_px", projector},
                                       {"camera_model", data->camera_model},
                                       {"projector_model", data->projector_model},
                                       {"camera_deviation_px", middle_px},
                                       {"camera_largest_deviation_px", worst_px},
                                       {"sample_deviation_mm",
                                        {pose.place_mm.x(), pose.place_mm.y(), pose.place_mm.z()}},
                                       {"sample_deviation_degrees", pose.turn_degrees},
                                       {"warnings", data->warnings},
                                       {"seconds", seconds}}
                            .dump()
                            .c_str());
    return;
  }
  std::printf("camera reprojection RMS     %.3f px  (%s)\n", camera, data->camera_model.c_str());
  std::printf("projector reprojection RMS  %.3f px  (%s)\n", projector,
              data->projector_model.c_str());
  std::printf("camera at the sample        +- %.3f px, %.3f px where it is known least\n",
              middle_px, worst_px);
  std::printf("sample's first corner       +- %.3f, %.3f, %.3f mm, turn +- %.3f degrees\n",
              pose.place_mm.x(), pose.place_mm.y(), pose.place_mm.z(), pose.turn_degrees);
  std::printf("%s  (%s)\n", folder.c_str(), time_taken(worked, seconds).c_str());
}

}  // namespace

void add_calibrate(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "calibrate",
      "Calibrate camera, projector, sample pose and radiometry from a session's own shots.\n\n"
      "Writes RUN/calibration: camera.yml and projector.yml (OpenCV's model, with covariance),\n"
      "pose.yml, response.yml, radiometry.yml and calibration.json (residuals by view).\n"
      "The reprojection RMS is the distance [px] between found corners and where the fitted model\n"
      "puts them. Below 0.3 px is good; above 1 px, look for a blurred or misread board: the "
      "report\n"
      "shows the residuals of every view. A low RMS says nothing about parts of the picture that "
      "no\n"
      "board reached: that is what the deviation (one standard deviation, px) tells, at the\n"
      "sample's distance, in the middle of the picture and where it is largest. The sample's "
      "place\n"
      "is that of its first corner along the camera's x, y, z at the pattern station.\n\n"
      "With --board, SESSION is a folder of photographs of that board and nothing else is needed:\n"
      "into RUN go camera.yml and calibration.json. With --projector, photographs named\n"
      "plane_<n>_board and plane_<n>_gray_<k> (or listed so in --table) give projector.yml, too;\n"
      "docs/howto/one-stage.md.");
  const auto options = add_session_options(*command);
  auto photographs = std::make_shared<PhotographCommand>();
  add_board_options(*command, photographs->board);
  add_table(*command, photographs->table);
  command->footer(
      "Examples: kappamu calibrate demo/session -o demo/run\n"
      "          kappamu calibrate boards -o camera --board 9x6 --square 25");
  command->callback(
      [options, photographs, &globals] { run_calibrate(*options, *photographs, globals); });
}

}  // namespace kappamu::app
