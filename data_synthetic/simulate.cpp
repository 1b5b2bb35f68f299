#include "data_synthetic/simulate.h"

#include <algorithm>
#include <functional>

#include "capture/session/session_files.h"
#include "core/error.h"
#include "core/processor_time.h"
#include "data_synthetic/rig/targets.h"
#include "data_synthetic/truth.h"
#include "io/image/image_file.h"
#include "io/image/plain_exr.h"
#include "io/npy.h"
#include "io/volume/npy_volume.h"

namespace kappamu::synthetic {

using capture::PatternRole;
using capture::PlannedPattern;

namespace {

/// How far the outer patches reach beyond the face the operator aims at, in face widths: the block
/// is never quite where it should be, and a dark strip of face would leave what is below
/// unmeasured. The holder's opaque mask stops what passes beside the block.
constexpr double patch_overhang = 0.04;
/// Exposure times of white target and chart reach from this signal of the white ...
constexpr double white_signal_low = 0.1;
/// ... to this one [full scales].
constexpr double white_signal_high = 0.85;
constexpr int white_exposures = 4;

/// Where the operator aims: the block as it is meant to stand, the lens without its distortion.
capture::ProjectorQuad aimed_quad(const Rig& rig) {
  const GridShape& grid = rig.sample.grid;
  const double half_x = 0.5 * grid.nx * grid.voxel_mm;
  const double half_y = 0.5 * grid.ny * grid.voxel_mm;
  calib::Lens lens = rig.projector.lens;
  lens.distortion = {};
  capture::ProjectorQuad quad{};
  constexpr std::array<std::array<double, 2>, 4> corners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d corner(corners[i][0] * half_x, corners[i][1] * half_y, 0.0);
    const Eigen::Vector2d pixel = lens.project(rig.projector.projector_from_world * corner);
    quad[i] = {pixel.x(), pixel.y()};
  }
  return quad;
}

/// The light of several images together.
Image<std::uint8_t> brightest_of(const std::vector<PlannedPattern>& patterns,
                                 const std::function<bool(int)>& chosen) {
  Image<std::uint8_t> out(patterns.front().image.width(), patterns.front().image.height(), 1);
  for (std::size_t m = 0; m < patterns.size(); ++m) {
    if (!chosen(static_cast<int>(m))) continue;
    for (std::size_t i = 0; i < out.size(); ++i) {
      // Patches share the pixels of their common edge, each with its part of the area.
      out.values()[i] =
          static_cast<std::uint8_t>(std::min(255, out.values()[i] + patterns[m].image.values()[i]));
    }
  }
  return out;
}

PlannedPattern pattern_from_file(const std::filesystem::path& file,
                                 const capture::Projector& projector, int number) {
  const Image<std::uint16_t> picture = io::read_code_image(file, [&](const io::ImageSize& size) {
    if (size.channels == 1 && size.width == projector.width && size.height == projector.height) {
      return;
    }
    throw InputError(file.string() + ": a pattern is a grey image of the projector's size, " +
                     std::to_string(projector.width) + " x " + std::to_string(projector.height) +
                     " pixels");
  });
  PlannedPattern pattern;
  pattern.id = "user_" + std::to_string(number);
  pattern.role = PatternRole::validate;
  pattern.image = Image<std::uint8_t>(picture.width(), picture.height(), 1);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (picture.values()[i] > 255) {
      throw InputError(file.string() + ": a pattern has 8 bits per pixel; convert the image");
    }
    pattern.image.values()[i] = static_cast<std::uint8_t>(picture.values()[i]);
  }
  return pattern;
}

/// Held-out patches and what the seen face sends out under them, noise-free.
void write_holdout(const SimulatedRig& simulated, Transport& transport, int n,
                   const std::filesystem::path& folder, Progress& progress) {
  const Rig& rig = simulated.rig();
  const GridShape& grid = rig.sample.grid;
  const FaceShape lit = face_shape(grid, rig.sample.lit_face());
  const FaceShape seen = face_shape(grid, rig.sample.seen_face());
  const int factor = transport.block().shape.nx / grid.nx;
  const std::vector<double> irradiance = patch_irradiance(lit, n);
  const std::vector<double> fine = split_cells(irradiance, lit, factor);
  std::vector<float> exitance;
  for (std::size_t c = 0; c < simulated.media().size(); ++c) {
    transport.set_medium(simulated.media()[c]);
    const std::vector<double> maps =
        transport.exitance(fine, rig.sample.seen_face(), [&](double fraction) {
          progress.update("held-out light", (static_cast<double>(c) + fraction) / 3.0, "");
        });
    const FaceShape fine_seen = face_shape(transport.block().shape, rig.sample.seen_face());
    const std::vector<double> mean = average_cells(maps, fine_seen, factor);
    exitance.insert(exitance.end(), mean.begin(), mean.end());
  }
  const auto size = [](int value) { return static_cast<std::size_t>(value); };
  io::write_npy(folder / "holdout_irradiance.npy", {size(n * n), size(lit.nv), size(lit.nu)},
                std::vector<float>(irradiance.begin(), irradiance.end()));
  io::write_npy(folder / "holdout_exitance.npy", {3, size(n * n), size(seen.nv), size(seen.nu)},
                exitance);
}

/// At the middles of the fitted voxels' faces.
void write_reflectance(const SimulatedRig& rig, const std::filesystem::path& folder) {
  const GridShape& grid = rig.rig().sample.grid;
  std::vector<float> values;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int v = 0; v < grid.ny; ++v) {
      for (int u = 0; u < grid.nx; ++u) {
        const Eigen::Vector2d at(u + 0.5, v + 0.5);
        values.push_back(static_cast<float>(rig.surface_reflectance(grid.voxel_mm * at)[c]));
      }
    }
  }
  io::write_npy(folder / "reflectance.npy",
                {3, static_cast<std::size_t>(grid.ny), static_cast<std::size_t>(grid.nx)}, values);
}

Truth truth_of(const SimulatedRig& simulated, const SimulationOptions& options,
               const capture::CapturePlan& plan) {
  const Rig& rig = simulated.rig();
  Truth truth;
  truth.sample = rig.sample.name;
  truth.seed = options.seed;
  truth.grid = rig.sample.grid;
  truth.transport_grid = simulated.transport().block().shape;
  truth.transport_model = simulated.transport().model();
  truth.transport_backend = simulated.transport().backend();
  truth.eta = rig.sample.eta;
  truth.setup = rig.sample.setup;
  truth.lit_face = rig.sample.lit_face();
  truth.seen_face = rig.sample.seen_face();
  truth.sides = plan.sample.sides;
  truth.holdout = options.holdout;
  truth.camera_lens = rig.camera_lens;
  truth.projector = rig.projector;
  truth.world_from_sample = rig.world_from_sample;
  truth.world_from_camera = rig.world_from_camera;
  truth.calibration_station = plan.calibration_station;
  truth.pattern_station = plan.pattern_station;
  truth.sensor = rig.sensor;
  truth.responsivity = rig.responsivity;
  return truth;
}

}  // namespace

std::vector<PlannedPattern> planned_patterns(const Rig& rig, const SimulationOptions& options) {
  const capture::ProjectorQuad quad = aimed_quad(rig);
  const GridShape& grid = rig.sample.grid;
  std::vector<PlannedPattern> patterns =
      capture::make_fit_patterns(rig.projector_size, quad, options.light, patch_overhang,
                                 {grid.nx * grid.voxel_mm, grid.ny * grid.voxel_mm});
  if (options.validation) {
    constexpr int n = 8;
    const std::vector<PlannedPattern> fine = capture::make_patch_patterns(
        rig.projector_size, quad, n, patch_overhang, PatternRole::validate, "validate_patch_");
    for (const int cell : {1 * n + 1, 2 * n + 5, 5 * n + 2, 6 * n + 6}) {
      patterns.push_back(fine[cell]);
    }
    patterns.push_back({"validate_cross",
                        brightest_of(fine,
                                     [](int cell) {
                                       const int row = cell / n;
                                       const int column = cell % n;
                                       return row == 3 || row == 4 || column == 3 || column == 4;
                                     }),
                        PatternRole::validate});
    patterns.push_back({"validate_checker",
                        brightest_of(fine, [](int cell) { return (cell / n + cell % n) % 2 == 0; }),
                        PatternRole::validate});
  }
  int number = 0;
  for (const std::filesystem::path& file : options.pattern_files) {
    patterns.push_back(pattern_from_file(file, rig.projector_size, number++));
  }
  return patterns;
}

capture::CapturePlan capture_plan(const SimulatedRig& simulated, const SimulationOptions& options,
                                  std::vector<PlannedPattern> patterns) {
  const Rig& rig = simulated.rig();
  capture::CapturePlan plan;
  const GridShape& fitted = rig.sample.grid;
  const GridShape& cells = simulated.transport().block().shape;
  plan.description = "the simulated rig: " + simulated.transport().model() + ", on " +
                     std::to_string(cells.nx) + " × " + std::to_string(cells.ny) + " × " +
                     std::to_string(cells.nz) + " cells, not the grid of " +
                     std::to_string(fitted.nx) + " × " + std::to_string(fitted.ny) + " × " +
                     std::to_string(fitted.nz) + " voxels to be fitted";
  plan.setup = rig.sample.setup;
  plan.sample.name = rig.sample.name;
  plan.sample.grid = {rig.sample.grid.nx, rig.sample.grid.ny, rig.sample.grid.nz};
  plan.sample.voxel_mm = rig.sample.grid.voxel_mm;
  plan.sample.eta = rig.sample.eta;
  plan.sample.sides = simulated.transport().block().sides;
  plan.sample.lit_face = rig.sample.lit_face();
  plan.sample.seen_face = rig.sample.seen_face();
  plan.sample.radiance = capture::Radiance::p1;
  plan.calibration_station = front_station;
  plan.pattern_station = rig.pattern_station();
  plan.patterns = std::move(patterns);
  plan.exposures_s = options.exposures_s;
  plan.target_exposures_s = SimulationOptions::geometric_exposures(
      simulated.white_exposure_s(white_signal_low), simulated.white_exposure_s(white_signal_high),
      white_exposures);
  plan.board = rig.board;
  plan.camera_board_views = options.board_views;
  plan.projected_board = rig.projected_board;
  plan.projector_plane_poses = options.projector_planes;
  plan.plane_light = options.plane_light;
  plan.projector_levels = capture::projector_levels(options.projector_levels);
  plan.ambient = options.room_light > 0.0;
  plan.both_faces = options.both_faces;
  plan.white_reflectance = white_target_reflectance;
  return plan;
}

SimulationReport simulate(const SimulationOptions& options, const std::filesystem::path& out,
                          const std::string& device, Progress& progress) {
  SimulationReport report;
  report.session = out / "session";
  report.truth = out / "truth";
  for (const std::filesystem::path& folder : {report.session, report.truth}) {
    std::error_code error;
    if (std::filesystem::symlink_status(folder, error).type() ==
        std::filesystem::file_type::not_found) {
      continue;
    }
    throw InputError(folder.string() +
                     " exists already: choose another output folder or remove it");
  }
  const Stopwatch transport_time;
  SimulatedRig rig(options, device);
  if (options.surface_reflectance > 0.0 && !options.both_faces &&
      rig.rig().sample.setup != capture::Setup::front_lit) {
    throw InputError(
        "surface reflectance is seen on the lit face, and that of the back-lit sample " +
        rig.rig().sample.name + " is not photographed: choose both faces");
  }
  std::vector<PlannedPattern> patterns = planned_patterns(rig.rig(), options);
  std::vector<Image<std::uint8_t>> images;
  images.reserve(patterns.size());
  for (const PlannedPattern& pattern : patterns) images.push_back(pattern.image);
  rig.prepare(images, progress);
  report.seconds["transport"] = transport_time.seconds();

  const Stopwatch shooting_time;
  const capture::CapturePlan plan = capture_plan(rig, options, std::move(patterns));
  const capture::Session session = capture::shoot_session(rig, plan, report.session, progress);
  report.seconds["shooting"] = shooting_time.seconds();

  const Stopwatch truth_time;
  for (const PlannedPattern& pattern : plan.patterns) {
    const Image<float> picture = rig.sample_radiance(pattern.image);
    const auto fill = [&](int y, std::size_t channel, float* values) {
      for (int x = 0; x < picture.width(); ++x)
        values[x] = picture(x, y, static_cast<int>(channel));
    };
    io::write_plain_exr(report.truth / "radiance" / (pattern.id + ".exr"),
                        {{0, 0, picture.width(), picture.height()},
                         picture.width(),
                         picture.height(),
                         {"R", "G", "B"},
                         {}},
                        fill);
  }
  const Truth truth = truth_of(rig, options, plan);
  for (std::size_t c = 0; c < truth.channels.size(); ++c) {
    const auto write = [&](const std::string& name, const Volume<double>& volume) {
      io::write_npy_volume(report.truth / (name + "_" + truth.channels[c] + ".npy"), volume);
    };
    write("kappa", rig.media()[c].kappa);
    write("mu", rig.media()[c].mu);
  }
  if (options.surface_reflectance > 0.0) write_reflectance(rig, report.truth);
  if (options.holdout > 0) {
    write_holdout(rig, rig.transport(), options.holdout, report.truth, progress);
  }
  write_truth(report.truth, truth);
  report.seconds["truth"] = truth_time.seconds();

  report.sample = truth.sample;
  report.grid = truth.grid;
  report.transport_grid = truth.transport_grid;
  report.transport_model = truth.transport_model;
  report.transport_backend = truth.transport_backend;
  report.patterns = static_cast<int>(plan.patterns.size());
  const std::size_t shown = session.patterns.size();  // the other files are photographs
  report.frames = static_cast<int>(capture::named_files(session).size() - shown);
  return report;
}

}  // namespace kappamu::synthetic
