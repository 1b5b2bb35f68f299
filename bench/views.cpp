#include "bench/views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "bench/chart.h"
#include "bench/record.h"
#include "calib/lens/projection_uncertainty.h"
#include "core/error.h"
#include "data_synthetic/rig/rig_corners.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

/// Adds one run's squares to `sums`.
void add_run(const synthetic::Rig& rig, const ViewsOptions& options, std::mt19937_64& random,
             ViewsCase& sums) {
  std::vector<Rigid> poses = rig.camera_from_board;
  std::shuffle(poses.begin(), poses.end(), random);
  poses.resize(static_cast<std::size_t>(sums.views));
  std::vector<calib::BoardView> views;
  for (const Rigid& pose : poses) {
    views.push_back(
        synthetic::seen_board(rig.camera_lens, rig.board, pose, options.corner_noise_px, random));
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

ViewsOptions quick_views() {
  ViewsOptions options;
  options.views = {3, 6, 12};
  options.runs = 4;
  return options;
}

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

Json views_record(const ViewsOptions& options, const std::vector<ViewsCase>& cases) {
  Json record = record_header("calibration", "none");
  record["runs"] = options.runs;
  record["corner_noise_px"] = options.corner_noise_px;
  record["seed"] = options.seed;
  Json& list = record["cases"] = Json::array();
  for (const ViewsCase& c : cases) {
    list.push_back({{"views", c.views},
                    {"refused", c.refused},
                    {"error_px", c.error_px},
                    {"predicted_px", c.predicted_px},
                    {"focal_relative", c.focal_relative},
                    {"focal_predicted", c.focal_predicted}});
  }
  return record;
}

void draw_views(const std::vector<ViewsCase>& cases, const std::filesystem::path& png) {
  const auto series = [&cases](const char* label, double ViewsCase::*value, double factor,
                               Series::Style style) {
    Series one;
    one.label = label;
    one.style = style;
    for (const ViewsCase& c : cases) {
      one.x.push_back(c.views);
      one.y.push_back(factor * c.*value);
    }
    return one;
  };
  Chart frame;
  frame.title = "camera calibration: error over the frame, at the sample's distance";
  frame.x_label = "board views";
  frame.y_label = "RMS [px]";
  frame.log_x = frame.log_y = true;
  frame.legend = "inside right top";
  frame.series = {
      series("against the truth", &ViewsCase::error_px, 1.0, Series::Style::line_and_points),
      series("as stated", &ViewsCase::predicted_px, 1.0, Series::Style::dashes)};
  Chart focal = frame;
  focal.title = "focal length";
  focal.y_label = "RMS error [%]";
  focal.series = {series("against the truth", &ViewsCase::focal_relative, 100.0,
                         Series::Style::line_and_points),
                  series("as stated", &ViewsCase::focal_predicted, 100.0, Series::Style::dashes)};
  const std::array<Chart, 2> charts{frame, focal};
  draw(charts, png, 2, 620, 420);
}

}  // namespace kappamu::bench
