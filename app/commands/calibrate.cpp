#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/session_command.h"
#include "pipeline/pipeline.h"
#include "report/read/run_data.h"

namespace kappamu::app {

namespace {

void run_calibrate(const SessionCommand& options, const Globals& globals) {
  const auto progress = make_progress();
  pipeline::Pipeline stages(options.session, options.run, options.force, options.follow_links);
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
      "is that of its first corner along the camera's x, y, z at the pattern station.");
  const auto options = add_session_options(*command);
  command->footer("Example: kappamu calibrate demo/session -o demo/run");
  command->callback([options, &globals] { run_calibrate(*options, globals); });
}

}  // namespace kappamu::app
