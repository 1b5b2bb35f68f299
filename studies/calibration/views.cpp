#include "studies/calibration/views.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "calib/lens/projection_uncertainty.h"
#include "core/error.h"
#include "studies/calibration/rig_corners.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

/// Adds one run's squares to `sums`.
void add_run(const synthetic::Rig& rig, const ViewsOptions& options, std::mt19937_64& random,
             ViewsCase& sums) {
  std::vector<Rigid> poses = rig.camera_from_board;
  std::shuffle(poses.begin(), poses.end(), random);
  poses.resize(static_cast<std::size_t>(sums.views));
  std::vector<calib::BoardView> views;
  for (const Rigid& pose : poses) {
    views.push_back(seen_board(rig.camera_lens, rig.board, pose, options.corner_noise_px, random));
  }
  const calib::Lens& truth = rig.camera_lens;
  calib::CameraCalibration found;
  try {
    found = calib::calibrate_camera(views, rig.board.square_mm, truth.width, truth.height);
  } catch (const InputError&) {
    ++sums.refused;
    return;
  }
  const double distance_mm = 4.2 * rig.size_mm;  // of the seen face from its station
  constexpr int across = 5;
  for (int k = 0; k < across * across; ++k) {
    const Eigen::Vector2d pixel((truth.width - 1.0) * (k % across) / (across - 1.0),
                                (truth.height - 1.0) * (k / across) / (across - 1.0));
    const Eigen::Vector3d point = distance_mm * truth.unproject(pixel);
    sums.error_px += (calib::projected_through_boards(found, poses, point) - pixel).squaredNorm();
    sums.predicted_px += calib::projection_covariance(found, pixel, distance_mm).trace();
  }
  sums.focal_relative += std::pow(found.lens.fx / truth.fx - 1.0, 2) * across * across;
  sums.focal_predicted += std::pow(found.standard_deviation(0) / truth.fx, 2) * across * across;
}

}  // namespace

std::vector<ViewsCase> measure_views(const ViewsOptions& options, Progress& progress) {
  std::vector<ViewsCase> cases;
  for (const int views : options.views) {
    ViewsCase one;
    one.views = views;
    for (int run = 0; run < options.runs; ++run) {
      progress.update("views",
                      (static_cast<double>(cases.size()) + 1.0 * run / options.runs) /
                          static_cast<double>(options.views.size()),
                      std::to_string(views) + " views");
      synthetic::SimulationOptions rig;
      rig.board_views = 60;
      rig.seed = options.seed + static_cast<std::uint64_t>(run);
      std::mt19937_64 random(rig.seed * 1000 + static_cast<std::uint64_t>(views));
      add_run(synthetic::make_rig(rig), options, random, one);
    }
    const int samples = 25 * std::max(1, options.runs - one.refused);
    for (double* sum :
         {&one.error_px, &one.predicted_px, &one.focal_relative, &one.focal_predicted}) {
      *sum = std::sqrt(*sum / samples);
    }
    cases.push_back(one);
  }
  return cases;
}

namespace {

void run_views(const Request& request, Progress& progress, const Save& save) {
  ViewsOptions options;
  if (request.size == Size::quick) {
    options.views = {3, 6, 12};
    options.runs = 4;
  }
  options.seed = request.seed;
  options.corner_noise_px = request.number("corner-noise", options.corner_noise_px);
  Json rows = Json::array();
  for (const ViewsCase& c : measure_views(options, progress)) {
    rows.push_back({{"views", c.views},
                    {"refused", c.refused},
                    {"error_px", c.error_px},
                    {"predicted_px", c.predicted_px},
                    {"focal_relative", c.focal_relative},
                    {"focal_predicted", c.focal_predicted}});
  }
  save({{"runs", options.runs}, {"corner_noise_px", options.corner_noise_px}, {"rows", rows}});
}

}  // namespace

Subject views_subject() {
  return {"calibration",
          "Error of a camera calibration against the number of board views (docs/calibration.md)",
          R"(  kappamu-studies calibration -o out/            3 to 40 views, 60 runs each: minutes
  kappamu-studies calibration --quick -o out/    seconds

Of the projection at the sample's distance over the whole frame and of the focal length,
each against what the calibrations state themselves.)",
          {{"calibration", "all counts", run_views}},
          {{"corner-noise",
            "Standard deviation of a corner, per coordinate [px] (default 0.03): 0.1 is what real "
            "boards leave, 0.0013 what rendered ones do",
            Setting::Kind::number, 1e-4, 10.0}}};
}

}  // namespace kappamu::studies
