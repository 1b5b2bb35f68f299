#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "data_synthetic/score.h"
#include "pipeline/verify.h"

namespace kappamu::app {

namespace {

using nlohmann::json;

json calibration_json(const synthetic::CalibrationErrors& errors) {
  return {{"camera_focal_relative", errors.camera_focal_relative},
          {"projector_focal_relative", errors.projector_focal_relative},
          {"camera_face_px", errors.camera_face_px},
          {"projector_face_px", errors.projector_face_px},
          {"camera_angle_degrees", errors.camera_angle_degrees},
          {"camera_position_mm", errors.camera_position_mm},
          {"projector_angle_degrees", errors.projector_angle_degrees},
          {"projector_position_mm", errors.projector_position_mm},
          {"scale_relative", errors.scale_relative},
          {"projector_black_relative", errors.projector_black_relative}};
}

json coverage_json(const std::map<std::string, synthetic::Coverage>& channels) {
  json object = json::object();
  for (const auto& [channel, found] : channels) {
    object[channel] = {{"within_2_std", found.within_two},
                       {"within_2_std_by_depth", found.within_two_by_depth},
                       {"median_deviations", found.median}};
  }
  return object;
}

json to_json(const synthetic::Score& score) {
  const auto optional = [](const std::optional<double>& value) {
    return value ? json(*value) : json(nullptr);
  };
  return {{"truth_E", optional(score.truth_E)},
          {"truth_E_by_channel", score.truth_E_by_channel},
          {"hdr_relative_error_median", optional(score.hdr_relative_error_median)},
          {"hdr_relative_error_by_pattern", score.hdr_relative_error_by_pattern},
          {"hdr_valid_fraction", score.hdr_valid_fraction},
          {"kappa_relative_error", optional(score.kappa_relative_error)},
          {"mu_relative_error", optional(score.mu_relative_error)},
          {"kappa_relative_error_by_depth", score.kappa_relative_error_by_depth},
          {"mu_relative_error_by_depth", score.mu_relative_error_by_depth},
          {"kappa_coverage", coverage_json(score.kappa_coverage)},
          {"mu_coverage", coverage_json(score.mu_coverage)},
          {"calibration", score.calibration ? calibration_json(*score.calibration) : json(nullptr)},
          {"seconds", score.seconds}};
}

void print_layers(const char* name, const std::vector<std::string>& channels,
                  const std::map<std::string, std::vector<double>>& layers) {
  for (const std::string& channel : channels) {
    std::printf("%s %-27s", name, (channel + " by depth, lit face first").c_str());
    for (const double error : layers.at(channel)) std::printf(" %.0f", 100.0 * error);
    std::printf(" %%\n");
  }
}

void print_coverage(const char* name, const std::vector<std::string>& channels,
                    const std::map<std::string, synthetic::Coverage>& coverage) {
  if (coverage.empty()) return;
  std::printf("%s within 2 standard deviations ", name);
  for (const std::string& channel : channels) {
    const synthetic::Coverage& found = coverage.at(channel);
    std::printf("  %s %.0f %% (median %.2g)", channel.c_str(), 100.0 * found.within_two,
                found.median);
  }
  std::printf("\n");
}

void print_table(const synthetic::Score& score) {
  if (score.truth_E) {
    std::printf("truth error E                   %.2e", *score.truth_E);
    for (const std::string& channel : score.channels) {
      std::printf("  %s %.2e", channel.c_str(), score.truth_E_by_channel.at(channel));
    }
    std::printf("\n");
  }
  if (score.hdr_relative_error_median) {
    std::printf("HDR relative error, median      %.2f %% (%.0f %% of the sample's pixels valid)\n",
                100.0 * *score.hdr_relative_error_median, 100.0 * score.hdr_valid_fraction);
  }
  if (score.calibration) {
    const synthetic::CalibrationErrors& errors = *score.calibration;
    std::printf("camera on the seen face         %.3f px, %.3f°, %.3f mm, focal length %.2f %%\n",
                errors.camera_face_px, errors.camera_angle_degrees, errors.camera_position_mm,
                100.0 * errors.camera_focal_relative);
    std::printf("projector on the lit face       %.3f px, %.3f°, %.3f mm, focal length %.2f %%\n",
                errors.projector_face_px, errors.projector_angle_degrees,
                errors.projector_position_mm, 100.0 * errors.projector_focal_relative);
    std::printf("radiance scale, worst channel   %.2f %%, projector's black %.2g %%\n",
                100.0 * errors.scale_relative, 100.0 * errors.projector_black_relative);
  }
  if (score.kappa_relative_error) {
    std::printf("κ relative error, median        %.1f %%\n", 100.0 * *score.kappa_relative_error);
    std::printf("μ relative error, median        %.1f %%\n", 100.0 * *score.mu_relative_error);
    print_layers("  κ", score.channels, score.kappa_relative_error_by_depth);
    print_layers("  μ", score.channels, score.mu_relative_error_by_depth);
    print_coverage("κ", score.channels, score.kappa_coverage);
    print_coverage("μ", score.channels, score.mu_coverage);
  }
}

}  // namespace

void add_score(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("score",
                         R"(Compare a finished run of a simulated capture with the ground truth.

The truth error E = Σ(L' − L)²/ΣL² compares what the run's volumes send out under light
patches the capture never showed, solved on a grid refined two times, with the noise-free
truth; below 1e-3 is good, a homogeneous block has a few 1e-2. The HDR error is the median
of |found/true − 1| over unflagged pixels on the sample. Calibration is compared on the
sample's faces, in pixels, and by its scale of radiance. κ and μ are compared voxel by
voxel, by layer below the lit face: continuous light leaves deep μ undetermined, so large
errors there do not spoil E. Whether the fit says so is the share of voxels whose log κ
and log μ lie within two stated standard deviations of the truth's mean over what the fit
resolves there (95 % if errors are Gaussian and stated rightly) and the median error in
standard deviations (then 0.67).
Parts a run does not have are left out.)");
  auto run = std::make_shared<std::string>();
  auto truth = std::make_shared<std::string>();
  command->add_option("run", *run, "Run folder, as written by `kappamu run`")
      ->required()
      ->type_name("RUN");
  command->add_option("--truth", *truth, "Truth folder, as written by `kappamu simulate`")
      ->required()
      ->type_name("TRUTH");
  command->footer(
      R"(Example: kappamu score demo/run --truth demo/truth
With --json: truth_E, hdr_relative_error_median, kappa_relative_error, mu_relative_error,
kappa_coverage, mu_coverage, calibration (objects) and more; null or empty where the run lacks
the part.)");
  command->callback([run, truth, &globals] {
    const auto progress = make_progress();
    pipeline::require_as_written(*run);
    const synthetic::Score score = synthetic::score_run(*run, *truth, globals.device, *progress);
    if (globals.json)
      print_json(to_json(score));
    else
      print_table(score);
  });
}

}  // namespace kappamu::app
