#include "calib/camera.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>

#include "calib/lens_model.h"
#include "calib/lens_solver.h"
#include "calib/opencv_convert.h"
#include "core/error.h"

namespace kappamu::calib {
namespace {

/// Projected minus observed corner; parameters: LensNumbers, camera_from_board as rotation vector
/// and translation.
struct CornerResidual {
  Eigen::Vector3d point_in_board;
  Eigen::Vector2d observed;
  bool square_pixels;

  template <class T>
  bool operator()(const T* numbers, const T* pose, T* residual) const {
    const Eigen::Matrix<T, 3, 1> in_board = point_in_board.cast<T>();
    Eigen::Matrix<T, 3, 1> point;
    ceres::AngleAxisRotatePoint(pose, in_board.data(), point.data());
    for (int k = 0; k < 3; ++k) point[k] += pose[3 + k];
    const Eigen::Matrix<T, 2, 1> pixel = project_numbers<T>(numbers, square_pixels, point);
    residual[0] = pixel.x() - observed.x();
    residual[1] = pixel.y() - observed.y();
    return true;
  }
};

struct Fit : LensFit {
  std::vector<std::array<double, 6>> poses;

  double akaike() const {
    return akaike_criterion(residual_sum_of_squares, residuals, parameter_count(model));
  }
  double bayesian() const {
    return bayesian_criterion(residual_sum_of_squares, residuals, parameter_count(model));
  }
};

const char* const undetermined =
    "camera calibration: the board photographs do not determine the lens; add views with the board "
    "tilted by 20 to 40 degrees in different directions and filling the frame";

/// Zhang's closed form and OpenCV's own refinement, with one radial coefficient at most.
Fit start_with_opencv(const std::vector<BoardView>& views, double square_mm, cv::Size size) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardView& view : views) {
    objects.push_back(board_points(view.corners.columns, view.corners.rows, square_mm));
    images.push_back(image_points(view.corners.pixels));
  }
  cv::Mat matrix;
  cv::Mat distortion;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::calibrateCamera(objects, images, size, matrix, distortion, rotations, translations,
                        cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST);
  } catch (const cv::Exception&) {
    throw InputError(undetermined);
  }
  Fit fit;
  fit.numbers = {matrix.at<double>(0, 0),
                 matrix.at<double>(1, 1),
                 matrix.at<double>(0, 2),
                 matrix.at<double>(1, 2),
                 distortion.at<double>(0),
                 0.0,
                 0.0,
                 0.0,
                 0.0};
  if (!std::all_of(fit.numbers.begin(), fit.numbers.end(),
                   [](double n) { return std::isfinite(n); })) {
    throw InputError(undetermined);
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    fit.poses.push_back(six_of(rotations[i], translations[i]));
  }
  return fit;
}

/// Least squares over lens and poses from the given start.
Fit refine(const std::vector<BoardView>& views, double square_mm, const Fit& start,
           LensModel model) {
  Fit fit = start;
  fit.model = model;
  const bool square_pixels = has_square_pixels(model);
  ceres::Problem problem;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const BoardCorners& corners = views[v].corners;
    for (int j = 0; j < corners.rows; ++j) {
      for (int i = 0; i < corners.columns; ++i) {
        auto* cost = new ceres::AutoDiffCostFunction<CornerResidual, 2, 9, 6>(new CornerResidual{
            {square_mm * i, square_mm * j, 0.0}, corners.at(i, j), square_pixels});
        problem.AddResidualBlock(cost, nullptr, fit.numbers.data(), fit.poses[v].data());
      }
    }
  }
  const bool usable = solve(problem, fit);

  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::SPARSE_QR;
  ceres::Covariance covariance(covariance_options);
  const double* block = fit.numbers.data();
  const std::vector<std::pair<const double*, const double*>> wanted{{block, block}};
  if (!usable || !covariance.Compute(wanted, &problem)) {
    throw InputError(undetermined);
  }
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> raw;
  covariance.GetCovarianceBlock(block, block, raw.data());
  const double freedom = static_cast<double>(fit.residuals) - parameter_count(model) -
                         6.0 * static_cast<double>(views.size());
  fit.covariance = raw * (fit.residual_sum_of_squares / std::max(freedom, 1.0));
  return fit;
}

ViewResidual residual_of(const Lens& lens, const Rigid& camera_from_board, const BoardView& view,
                         double square_mm) {
  ViewResidual result;
  result.name = view.name;
  result.pixels = view.corners.pixels;
  double sum = 0.0;
  for (int j = 0; j < view.corners.rows; ++j) {
    for (int i = 0; i < view.corners.columns; ++i) {
      const Eigen::Vector3d point(square_mm * i, square_mm * j, 0.0);
      const Eigen::Vector2d residual =
          lens.project(camera_from_board * point) - view.corners.at(i, j);
      result.residuals.push_back(residual);
      sum += residual.squaredNorm();
    }
  }
  result.rms_px = std::sqrt(sum / static_cast<double>(result.residuals.size()));
  return result;
}

}  // namespace

double CameraCalibration::standard_deviation(int parameter) const {
  return std::sqrt(covariance(parameter, parameter));
}

CameraCalibration calibrate_camera(const std::vector<BoardView>& views, double square_mm, int width,
                                   int height, std::optional<LensModel> model) {
  if (views.size() < 3) {
    throw InputError("camera calibration: " + std::to_string(views.size()) +
                     " board photographs given and at least 3 are needed (10 or more are good); "
                     "add entries to calibration.camera_boards in session.json");
  }
  const Fit start = start_with_opencv(views, square_mm, cv::Size(width, height));
  Fit best;
  if (model) {
    best = refine(views, square_mm, start, *model);
  } else {
    best = refine(views, square_mm, start, LensModel::radial1);
    Fit previous = best;
    for (const LensModel richer : {LensModel::radial2, LensModel::radial2_tangential}) {
      previous = refine(views, square_mm, previous, richer);
      if (previous.akaike() < best.akaike()) best = previous;
    }
    // k3 trades against k2 inside the board's reach and runs wild outside: on strong evidence only.
    const Fit full = refine(views, square_mm, previous, LensModel::full);
    if (full.bayesian() < best.bayesian() && full.akaike() < best.akaike()) best = full;
  }

  CameraCalibration result;
  result.model = best.model;
  result.lens = lens_of(best.numbers, has_square_pixels(best.model), width, height);
  result.covariance = best.covariance;
  result.converged = best.converged;
  result.rms_px =
      std::sqrt(best.residual_sum_of_squares / (0.5 * static_cast<double>(best.residuals)));
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.camera_from_board.push_back(rigid_of(best.poses[v]));
    result.views.push_back(
        residual_of(result.lens, result.camera_from_board.back(), views[v], square_mm));
  }
  return result;
}

Rigid board_pose(const Lens& lens, const BoardCorners& corners, double square_mm,
                 const std::string& name) {
  cv::Mat rotation;
  cv::Mat translation;
  bool found = false;
  try {
    found = cv::solvePnP(board_points(corners.columns, corners.rows, square_mm),
                         image_points(corners.pixels), camera_matrix(lens), distortion_vector(lens),
                         rotation, translation, false, cv::SOLVEPNP_ITERATIVE);
  } catch (const cv::Exception&) {
    found = false;
  }
  if (!found || translation.at<double>(2) <= 0.0) {
    throw InputError(name + ": no pose of the board explains its corners; take the picture again");
  }
  return rigid_of(six_of(rotation, translation));
}

}  // namespace kappamu::calib
