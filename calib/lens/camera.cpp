#include "calib/lens/camera.h"

#include <algorithm>
#include <cmath>

#include "calib/lens/camera_choice.h"
#include "calib/lens/camera_fit.h"
#include "calib/lens/lens_model.h"
#include "calib/lens/opencv_convert.h"
#include "calib/targets/board_picture.h"
#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

/// Distances of all corners from where `fit` puts them, those left out included.
std::vector<std::vector<double>> distances(const CameraSetting& setting, const CameraFit& fit) {
  std::vector<std::vector<double>> result(setting.views.size());
  for (std::size_t v = 0; v < setting.views.size(); ++v) {
    for (std::size_t k = 0; k < setting.views[v].corners.pixels.size(); ++k) {
      result[v].push_back(corner_residual(setting, fit, v, k).norm());
    }
  }
  return result;
}

/// Corners within six standard deviations of one coordinate; that is taken from the median, which
/// of a distance in the plane is 1.1774 deviations. Gaussian noise passes once in 65 million.
CornerMask within_six_deviations(const std::vector<std::vector<double>>& distances) {
  std::vector<double> all;
  for (const auto& view : distances) all.insert(all.end(), view.begin(), view.end());
  constexpr double smallest_px = 0.05;  // no corner is wrong by less
  const double bound = std::max(6.0 * upper_median(std::move(all)) / 1.1774, smallest_px);
  CornerMask mask;
  for (const auto& view : distances) {
    mask.emplace_back();
    for (const double distance : view) mask.back().push_back(distance <= bound ? 1 : 0);
  }
  return mask;
}

/// Sets the mask and returns the fit that found it. Where plain least squares shows corners too far
/// off, Cauchy's loss finds where the others want the lens, and the mask is drawn about that.
CameraFit leave_out_outliers(CameraSetting& setting, const CameraFit& start, LensModel model) {
  CameraProblem plain(setting, start, model, Bend::none);
  plain.solve();
  CameraFit fit = plain.fit();
  const CornerMask all = setting.mask;
  CornerMask mask = within_six_deviations(distances(setting, fit));
  if (mask == all) return fit;
  constexpr double cauchy_px = 0.5;  // a few times the scatter of a clean corner
  CameraProblem robust(setting, fit, model, Bend::none, cauchy_px);
  robust.solve();
  setting.mask = within_six_deviations(distances(setting, robust.fit()));
  constexpr int passes = 3;
  fit = robust.fit();
  for (int pass = 0; pass < passes; ++pass) {
    for (auto& view : setting.mask) {
      // A view left with nothing has no pose; it keeps all and shows in its residual.
      if (std::count(view.begin(), view.end(), 1) < 6) std::fill(view.begin(), view.end(), 1);
    }
    CameraProblem problem(setting, fit, model, Bend::none);
    problem.solve();
    fit = problem.fit();
    mask = within_six_deviations(distances(setting, fit));
    if (mask == setting.mask) break;
    setting.mask = mask;
  }
  return fit;
}

CameraFit start_from(const CameraSetting& setting, const KnownLens& known) {
  CameraFit fit;
  for (const BoardView& view : setting.views) {
    fit.poses.push_back(six_of(board_pose(known.lens, view.corners, setting.square_mm, view.name)));
    shorten(fit.poses.back());
  }
  fit.numbers = numbers_of(known.lens);
  // The models that find outliers and come first have none of k3 to k6.
  if (known.use == LensUse::start) std::fill(fit.numbers.begin() + 8, fit.numbers.end(), 0.0);
  return fit;
}

CornerMask everything(const std::vector<BoardView>& views) {
  CornerMask mask;
  for (const BoardView& view : views) mask.emplace_back(view.corners.pixels.size(), 1);
  return mask;
}

}  // namespace

double CameraCalibration::standard_deviation(int parameter) const {
  return std::sqrt(covariance(parameter, parameter));
}

CameraCalibration calibrate_camera(const std::vector<BoardView>& views, double square_mm, int width,
                                   int height, std::optional<LensModel> model,
                                   const std::optional<KnownLens>& known) {
  const bool held = known && known->use == LensUse::held;
  if (held) model = LensModel::held;
  if (views.size() < (held ? 1 : least_views)) {
    throw InputError("camera calibration: " + std::to_string(views.size()) +
                     " board photographs given and at least 3 are needed (10 or more are good); "
                     "photograph the board in more poses (calibration.camera_boards of a session)");
  }
  CameraSetting setting{views, square_mm, everything(views)};
  CameraFit start = known ? start_from(setting, *known) : start_camera(setting, width, height);
  // Outliers are told under a lens that leaves no error of its own.
  start = leave_out_outliers(setting, start, model.value_or(LensModel::radial2_tangential));
  CameraCalibration result;
  if (!model) {
    const double freedom =
        static_cast<double>(start.residuals) - parameter_count(start.model) - 6.0 * views.size();
    setting.noise_px = std::sqrt(start.residual_sum_of_squares / std::max(freedom, 1.0));
    CameraChoice choice = choose_camera(setting, start);
    start = std::move(choice.fit);
    result.scores = std::move(choice.scores);
  }
  CameraProblem problem(setting, start, model.value_or(start.model),
                        start.bent ? Bend::free : Bend::none);
  problem.solve();
  const CameraFit& fit = problem.fit();
  CameraSpread spread = problem.covariance();
  result.joint_covariance = std::move(spread.covariance);
  result.overdispersion = spread.overdispersion;
  result.model = fit.model;
  result.lens = lens_of(fit.numbers, pixel_shape(fit.model), width, height);
  result.covariance = result.joint_covariance.topLeftCorner<lens_numbers, lens_numbers>();
  result.bend_mm = fit.bend_mm;
  result.converged = fit.converged;
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.camera_from_board.push_back(rigid_of(fit.poses[v]));
    ViewResidual view{views[v].name, 0.0, views[v].corners.pixels, {}, {}};
    for (std::size_t k = 0; k < setting.mask[v].size(); ++k) {
      if (setting.mask[v][k] == 0) view.left_out.push_back(static_cast<int>(k));
    }
    result.views.push_back(std::move(view));
  }
  measure_residuals(views, square_mm, result);
  return result;
}

void measure_residuals(const std::vector<BoardView>& views, double square_mm,
                       CameraCalibration& camera) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const BoardCorners& corners = views[v].corners;
    const BoardShape board{corners.columns, corners.rows, square_mm, corners.staggered};
    ViewResidual& view = camera.views[v];
    view.residuals.clear();
    double view_sum = 0.0;
    for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
      const auto [i, j] = corners.place(k);
      const Eigen::Vector3d corner = bent_corner<double>(board, camera.bend_mm.data(), i, j);
      view.residuals.push_back(camera.lens.project(camera.camera_from_board[v] * corner) -
                               corners.pixels[k]);
      const bool out = std::find(view.left_out.begin(), view.left_out.end(), static_cast<int>(k)) !=
                       view.left_out.end();
      if (!out) view_sum += view.residuals.back().squaredNorm();
    }
    const std::size_t used = corners.pixels.size() - view.left_out.size();
    view.rms_px = std::sqrt(view_sum / static_cast<double>(used));
    sum += view_sum;
    count += used;
  }
  camera.rms_px = std::sqrt(sum / static_cast<double>(count));
}

Rigid board_pose(const Lens& lens, const BoardCorners& corners, double square_mm,
                 const std::string& name, const std::array<double, 2>& bend_mm) {
  cv::Mat rotation;
  cv::Mat translation;
  bool found = false;
  std::vector<cv::Point3f> points = board_points(corners, square_mm);
  try {
    found =
        cv::solvePnP(points, image_points(corners.pixels), camera_matrix(lens),
                     distortion_vector(lens), rotation, translation, false, cv::SOLVEPNP_ITERATIVE);
    if (found && bend_mm != std::array<double, 2>{}) {
      // OpenCV starts from a homography only where the board is flat.
      const BoardShape board{corners.columns, corners.rows, square_mm, corners.staggered};
      for (std::size_t k = 0; k < points.size(); ++k) {
        const auto [i, j] = corners.place(k);
        points[k].z = static_cast<float>(bent_corner<double>(board, bend_mm.data(), i, j).z());
      }
      found = cv::solvePnP(points, image_points(corners.pixels), camera_matrix(lens),
                           distortion_vector(lens), rotation, translation, true,
                           cv::SOLVEPNP_ITERATIVE);
    }
  } catch (const cv::Exception&) {
    found = false;
  }
  if (!found || translation.at<double>(2) <= 0.0) {
    throw InputError(name + ": no pose of the board explains its corners; take the picture again");
  }
  return rigid_of(six_of(rotation, translation));
}

}  // namespace kappamu::calib
