#include "tests/report/made_up_run.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "calib/calibration_file.h"
#include "capture/session/session.h"
#include "io/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/measurements_file.h"
#include "io/npy.h"
#include "pipeline/records/fit_record.h"
#include "pipeline/records/run_record.h"
#include "pipeline/records/versions.h"

namespace kappamu {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double noise_of_value = 0.01;  // relative
constexpr double noise_floor = 2e-5;     // of the brightest value

/// Centre of the lit patch of a pattern, as fractions of the face.
std::array<double, 2> patch_centre(int pattern) {
  return {(pattern % 4 + 0.5) / 4.0, (pattern / 4 % 4 + 0.5) / 4.0};
}

struct MadeUpSurface {
  SurfaceMeasurements measured;
  std::vector<float> truth;  ///< measured.value without its noise
};

MadeUpSurface make_surface(const MadeUpRun& options, int patterns, int first,
                           std::mt19937& random) {
  MadeUpSurface surface;
  SurfaceMeasurements& measured = surface.measured;
  measured.grid = {options.nx, options.ny, options.nz, 0.5};
  measured.channels = {"R", "G", "B"};
  measured.patterns = patterns;
  std::normal_distribution<double> normal;
  const std::array<double, 3> spread{0.16, 0.12, 0.08};
  for (int m = 0; m < patterns; ++m) {
    const auto [cx, cy] = patch_centre(first + m);
    for (int y = 0; y < options.ny; ++y)
      for (int x = 0; x < options.nx; ++x)
        measured.irradiance.push_back(std::abs((x + 0.5) / options.nx - cx) < 0.125 &&
                                              std::abs((y + 0.5) / options.ny - cy) < 0.125
                                          ? 1.0F
                                          : 2e-4F);
  }
  for (const double width : spread)
    for (int m = 0; m < patterns; ++m) {
      const auto [cx, cy] = patch_centre(first + m);
      for (int y = 0; y < options.ny; ++y)
        for (int x = 0; x < options.nx; ++x) {
          const double r = std::hypot((x + 0.5) / options.nx - cx, (y + 0.5) / options.ny - cy);
          const double value = 0.1 * std::exp(-r / width);
          const double sigma = noise_of_value * value + noise_floor * 0.1;
          surface.truth.push_back(static_cast<float>(value));
          measured.value.push_back(static_cast<float>(value + sigma * normal(random)));
          measured.variance.push_back(static_cast<float>(sigma * sigma));
          measured.mask.push_back(x == 0 && y < 4 ? 0 : 1);
        }
    }
  return surface;
}

void write_prediction(const fs::path& file, const MadeUpSurface& surface, double model_error) {
  const SurfaceMeasurements& measured = surface.measured;
  std::vector<float> prediction = surface.truth;
  const auto nu = static_cast<std::size_t>(measured.seen_shape().nu);
  for (std::size_t i = 0; i < prediction.size(); ++i)
    prediction[i] *=
        static_cast<float>(1.0 + model_error * std::sin(0.4 * static_cast<double>(i % nu)));
  io::write_npy(file,
                {measured.channels.size(), static_cast<std::size_t>(measured.patterns),
                 static_cast<std::size_t>(measured.seen_shape().nv), nu},
                std::span<const float>(prediction));
}

pipeline::FitRecord record_of(const MadeUpRun& options) {
  pipeline::FitEvidence evidence;
  evidence.channels = {
      {"R", options.converged ? inverse::FitStatus::converged : inverse::FitStatus::ran_out, 0.98}};
  evidence.used = 0.99;
  evidence.warnings = options.converged ? 0 : 1;
  evidence.validation = {{options.model_error * options.model_error, 1.0, 1e-4, 1000}};
  evidence.validation_names = {"validation pattern 0"};
  if (options.with_session) evidence.camera_rms_px = options.camera_rms_px;
  if (options.with_session) evidence.projector_rms_px = 0.18;
  pipeline::FitRecord record;
  record.status =
      evidence.channels.front().status == inverse::FitStatus::converged ? "converged" : "ran_out";
  record.grid = {options.nx, options.ny, options.nz};
  record.verdict = pipeline::make_verdict(evidence);
  return record;
}

void write_fit(const fs::path& run, const MadeUpRun& options) {
  json channels = json::array();
  const std::vector<std::size_t> shape{static_cast<std::size_t>(options.nz),
                                       static_cast<std::size_t>(options.ny),
                                       static_cast<std::size_t>(options.nx)};
  const std::array<const char*, 3> names{"R", "G", "B"};
  for (std::size_t c = 0; c < names.size(); ++c) {
    std::vector<float> kappa, mu;
    for (int z = 0; z < options.nz; ++z)
      for (int y = 0; y < options.ny; ++y)
        for (int x = 0; x < options.nx; ++x) {
          const double blob = std::exp(
              -0.02 * (std::pow(x - 12.0, 2) + std::pow(y - 18.0, 2) + 4.0 * std::pow(z - 5.0, 2)));
          kappa.push_back(
              static_cast<float>((0.3 + 0.1 * static_cast<double>(c)) * (1.0 - 0.6 * blob)));
          mu.push_back(
              static_cast<float>(0.004 * (1.0 + static_cast<double>(c)) * (1.0 + 2.0 * blob)));
        }
    io::write_npy(run / "fit" / ("kappa_" + std::string(names[c]) + ".npy"), shape,
                  std::span<const float>(kappa));
    io::write_npy(run / "fit" / ("mu_" + std::string(names[c]) + ".npy"), shape,
                  std::span<const float>(mu));
    const auto write = [&](const std::string& name, const std::vector<float>& values) {
      io::write_npy(run / "fit" / (name + "_" + names[c] + ".npy"), shape,
                    std::span<const float>(values));
    };
    std::vector<float> kappa_std, mu_std, resolution;
    for (std::size_t i = 0; i < kappa.size(); ++i) {
      const float depth = static_cast<float>(i) / static_cast<float>(kappa.size());
      kappa_std.push_back(kappa[i] * (0.4F - 0.3F * depth));
      mu_std.push_back(mu[i] * (0.9F - 0.5F * depth));
      resolution.push_back(depth);
    }
    write("std_kappa", kappa_std);
    write("std_mu", mu_std);
    write("resolution_kappa", resolution);
    write("resolution_mu", resolution);
    json history = json::array();
    for (int i = 0; i < 60; ++i)
      history.push_back(
          {{"adjoint_solves", i + 1},
           {"objective", (4e3 * std::pow(0.83, i) + 1.0) * (1.0 + 0.2 * static_cast<double>(c))},
           {"chi2_per_value", 1.0 + 300.0 * std::pow(0.85, i)}});
    channels.push_back(
        {{"name", names[c]},
         {"status", options.converged ? "converged" : "ran_out"},
         {"uncertainty",
          {{"sentence", "Beyond 3 mm below the seen face the data say nothing about " +
                            std::string(names[c]) + "."}}},
         {"reason", options.converged ? "gradient below tolerance" : "evaluation limit reached"},
         {"model", {{"name", "volume"}, {"reason", "Simpler ones leave chi2 at 40."}}},
         {"chi2_per_value", 0.98 + 0.05 * static_cast<double>(c)},
         {"seconds", 14.2},
         {"history", history}});
  }
  nlohmann::ordered_json fit{{"format", "kappamu-fit"}, {"version", 1}, {"voxel_mm", 0.5}};
  pipeline::add_fit_record(record_of(options), fit);
  fit["channels"] = channels;
  fit["warnings"] =
      options.converged ? json::array() : json{"channel R stopped at its evaluation limit"};
  io::write_text_atomically(run / "fit" / "fit.json", fit.dump(1));
}

std::vector<calib::ViewResidual> views(double rms, int width, int height, int count,
                                       std::mt19937& random) {
  std::normal_distribution<double> normal(0.0, rms / std::sqrt(2.0));
  std::vector<calib::ViewResidual> result;
  for (int v = 0; v < count; ++v) {
    calib::ViewResidual view;
    view.name = "calibration/board_" + std::to_string(v) + ".png";
    view.rms_px = rms * (0.8 + 0.05 * v);
    const double x0 = width * (0.05 + 0.4 * (v % 3) / 2.0);
    const double y0 = height * (0.05 + 0.3 * (v / 3 % 3) / 2.0);
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 9; ++i) {
        view.pixels.emplace_back(x0 + 0.055 * width * i + 3 * j, y0 + 0.09 * height * j + 2 * i);
        view.residuals.emplace_back(normal(random), normal(random));
      }
    result.push_back(view);
  }
  return result;
}

void write_calibration(const fs::path& run, const MadeUpRun& options, std::mt19937& random) {
  calib::CalibrationResult calibration;
  calibration.camera.lens = {640, 480, 900.0, 900.0, 320.0, 240.0, {}};
  calibration.camera.rms_px = options.camera_rms_px;
  calibration.camera.views = views(options.camera_rms_px, 640, 480, 9, random);
  calibration.camera.camera_from_board.resize(9);
  calibration.projector.lens = {1024, 768, 1500.0, 1500.0, 512.0, 384.0, {}};
  calibration.projector.rms_px = 0.18;
  calibration.projector.views = views(0.18, 1024, 768, 6, random);
  calibration.projector.station_from_plane.resize(6);
  calibration.radiometry.bit_depth = 12;
  calibration.radiometry.response.linear.resize(3);
  calibration.radiometry.black_level = {0.0, 0.0, 0.0};
  calibration.radiometry.noise.resize(3, {20000.0, 5.0, false});
  for (std::size_t c = 0; c < 3; ++c)
    for (int code = 0; code < 4096; ++code)
      calibration.radiometry.response.linear[c].push_back(
          std::pow(code / 4095.0, 2.0 + 0.1 * static_cast<double>(c)));
  calibration.scale = {1.0, 1.0, 1.0};
  calibration.white.scale = calibration.scale;
  calibration.white.residual_rms = {0.01, 0.01, 0.01};
  calibration.projector_curve = calib::curve_from_signals(
      {0, 64, 128, 255},
      {{0.0, 0.0, 0.0}, {0.05, 0.06, 0.05}, {0.22, 0.22, 0.23}, {1.0, 1.0, 1.0}});
  calibration.white.black_measured = true;
  calibration.white.projector_black = 1.0 / 2000.0;
  calibration.white.room_light = 0.01;
  for (calib::SamplePose* pose : {&calibration.calibration_pose, &calibration.pattern_pose})
    pose->corners_px.fill(Eigen::Vector2d::Zero());
  calib::save_calibration(run / "calibration", calibration);
}

void write_hdr(const fs::path& file, int pattern) {
  constexpr int width = 160, height = 120;
  io::ExrImage image;
  image.width = width;
  image.height = height;
  const auto [cx, cy] = patch_centre(pattern);
  for (const char* channel : {"R", "G", "B"}) {
    std::vector<float> radiance, variance, flags;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double r = std::hypot(x / 160.0 - 0.2 - 0.6 * cx, y / 120.0 - 0.2 - 0.6 * cy);
        const bool inside = x > 24 && x < 136 && y > 18 && y < 102;
        radiance.push_back(static_cast<float>(inside ? 8.0 * std::exp(-r / 0.1) : 0.0));
        variance.push_back(1e-8F + 1e-5F * radiance.back());
        flags.push_back(inside ? 0.0F : 2.0F);
      }
    image.channels[channel] = radiance;
    image.channels[std::string("variance.") + channel] = variance;
    image.channels[std::string("flags.") + channel] = flags;
  }
  io::write_exr(file, image);
}

capture::Session make_session(const fs::path& folder, const MadeUpRun& options) {
  capture::Session session;
  session.folder = folder;
  session.sample = {"made-up block", {options.nx, options.ny, options.nz}, 0.5};
  session.camera = {640,          480,          12,          capture::Encoding::response,
                    std::nullopt, std::nullopt, std::nullopt};
  session.projector = {1024, 768};
  session.pattern_station = "back";
  for (int i = 0; i < options.fit_patterns + options.validate_patterns; ++i) {
    const bool fit = i < options.fit_patterns;
    const std::string id =
        (fit ? "fit_0" : "validate_0") + std::to_string(fit ? i : i - options.fit_patterns);
    const std::string frame = "frames/" + id;
    session.patterns.push_back(
        {id,
         "patterns/" + id + ".png",
         fit ? capture::PatternRole::fit : capture::PatternRole::validate,
         {{frame + "_0.png", 1.0 / 30.0}, {frame + "_1.png", 0.25}, {frame + "_2.png", 2.0}}});
    Image<std::uint8_t> light(1024, 768, 1, 0);
    const auto [cx, cy] = patch_centre(i);
    for (int y = 0; y < 768; ++y)
      for (int x = 0; x < 1024; ++x)
        if (std::abs(x / 1024.0 - 0.2 - 0.6 * cx) < 0.07 &&
            std::abs(y / 768.0 - 0.2 - 0.6 * cy) < 0.07)
          light(x, y) = 255;
    io::write_image(folder / session.patterns.back().image, light);
  }
  capture::Calibration& calibration = session.calibration;
  calibration.board = {9, 6, 4.0};
  calibration.projected_board = {9, 6, 40.0, {300.0, 200.0}};
  for (int i = 0; i < 9; ++i)
    calibration.camera_boards.push_back({"calibration/board_" + std::to_string(i) + ".png", 0.1});
  for (int i = 0; i < 6; ++i) {
    const std::string plane = "calibration/plane_" + std::to_string(i);
    calibration.projector_planes.push_back(
        {{plane + "_board.png", 0.1}, capture::Frame{plane + "_projected.png", 0.1}, {}});
  }
  calibration.sample_views = {
      {"front", Face::z_minus, {"calibration/sample_front.png", 0.1}, std::nullopt},
      {"back", Face::z_plus, {"calibration/sample_back.png", 0.1}, std::nullopt}};
  calibration.dark = {{"calibration/dark_0.png", 0.1}};
  calibration.white_target = capture::WhiteTarget{0.99, {{"calibration/white_0.png", 0.1}}};
  capture::write_session(session);
  return session;
}

}  // namespace

fs::path make_run(const fs::path& folder, const MadeUpRun& options) {
  std::mt19937 random(7);
  const fs::path run = folder / "run";
  pipeline::RunRecord record;
  record.input_fingerprint = "0123456789abcdef";
  record.device = "a made-up device";
  record.versions = pipeline::library_versions();
  for (const char* name : pipeline::stage_names)
    record.stages[name] = {{pipeline::StageStatus::done, "key", {}, {}}, 3.5, {}};

  const MadeUpSurface fit = make_surface(options, options.fit_patterns, 0, random);
  io::write_measurements(run / "measurements", fit.measured);
  write_prediction(run / "fit" / "prediction.npy", fit, options.model_error);
  write_fit(run, options);
  record.input_kind = pipeline::RunRecord::InputKind::measurements;
  record.input = run / "measurements";
  if (options.with_session) {
    const capture::Session session = make_session(folder / "session", options);
    record.input_kind = pipeline::RunRecord::InputKind::session;
    record.input = session.folder;
    const MadeUpSurface validate =
        make_surface(options, options.validate_patterns, options.fit_patterns, random);
    io::write_measurements(run / "measurements_validate", validate.measured);
    write_prediction(run / "fit" / "prediction_validate.npy", validate, options.model_error);
    write_calibration(run, options, random);
    for (std::size_t i = 0; i < session.patterns.size(); ++i)
      write_hdr(run / "hdr" / (session.patterns[i].id + ".exr"), static_cast<int>(i));
  }
  pipeline::write_run_record(record, run);
  return run;
}

}  // namespace kappamu
