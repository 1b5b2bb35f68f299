#include "calib/projector/projector.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "calib/lens/lens_model.h"
#include "calib/lens/lens_solver.h"
#include "calib/lens/opencv_convert.h"
#include "calib/lens/rigid_motion.h"
#include "calib/targets/board_shape.h"
#include "core/error.h"

namespace kappamu::calib {
namespace {

const char* const undetermined =
    "projector calibration: the planes do not determine the projector; add entries to "
    "calibration.projector_planes with the plane tilted by 20 to 40 degrees in different "
    "directions";

/// Printed corner, camera pixels; the camera's lens is known.
struct PrintedCornerResidual {
  LensNumbers camera;
  Eigen::Vector3d point_in_plane;
  Eigen::Vector2d observed;

  template <class T>
  bool operator()(const T* plane, T* residual) const {
    std::array<T, lens_numbers> numbers;
    for (int k = 0; k < lens_numbers; ++k) numbers[k] = T(camera[k]);
    const Eigen::Matrix<T, 3, 1> point = moved<T>(plane, point_in_plane.cast<T>());
    const Eigen::Matrix<T, 2, 1> pixel =
        project_numbers<T>(numbers.data(), PixelShape::rectangular, point);
    residual[0] = pixel.x() - observed.x();
    residual[1] = pixel.y() - observed.y();
    return true;
  }
};

/// Projected corner: the camera's ray meets the plane, and the projector sees that point at a
/// pixel known exactly. The error is the camera's, so the residual is scaled to camera pixels.
struct ProjectedCornerResidual {
  Eigen::Vector3d ray;
  Eigen::Vector2d projector_pixel;
  double camera_px_per_projector_px;
  PixelShape pixels;

  template <class T>
  bool operator()(const T* numbers, const T* projector, const T* plane, T* residual) const {
    const Eigen::Matrix<T, 3, 1> point = met_by<T>(plane, ray.cast<T>());
    const Eigen::Matrix<T, 2, 1> pixel =
        project_numbers<T>(numbers, pixels, moved<T>(projector, point));
    residual[0] = (pixel.x() - projector_pixel.x()) * camera_px_per_projector_px;
    residual[1] = (pixel.y() - projector_pixel.y()) * camera_px_per_projector_px;
    return true;
  }
};

struct Setting {
  const Lens& camera;
  const capture::Board& printed;
  const capture::ProjectedBoard& projected;
  const std::vector<PlaneView>& planes;
  int width = 0;  ///< of the projector
  int height = 0;

  Eigen::Vector2d projector_pixel(const PlaneView& plane, std::size_t k) const {
    return calib::projector_pixel(projected, plane.projected, k);
  }
  Eigen::Vector3d printed_point(const PlaneView& plane, std::size_t k) const {
    const BoardCorners& corners = plane.printed;
    const auto [i, j] = corners.place(k);
    return BoardShape{corners.columns, corners.rows, printed.square_mm, corners.staggered}
        .flat_point(i, j);
  }
};

struct Fit : LensFit {
  std::array<double, 6> projector{};
  std::vector<std::array<double, 6>> planes;
  double noise_px = 0.0;  ///< scatter of a corner per coordinate
  Eigen::Matrix<double, 6, 6> pose_covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Plane poses from the printed board, then Zhang's method with the roles of camera and projector
/// exchanged.
Fit start_with_opencv(const Setting& setting) {
  Fit fit;
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const PlaneView& plane : setting.planes) {
    const Rigid pose =
        board_pose(setting.camera, plane.printed, setting.printed.square_mm, plane.name);
    fit.planes.push_back(six_of(pose));
    std::vector<cv::Point3f> points;
    std::vector<cv::Point2f> pixels;
    for (std::size_t k = 0; k < plane.projected.pixels.size(); ++k) {
      const Eigen::Vector3d point = meet_plane(setting.camera, pose, plane.projected.pixels[k]);
      points.emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()), 0.0F);
      const Eigen::Vector2d pixel = setting.projector_pixel(plane, k);
      pixels.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
    }
    objects.push_back(std::move(points));
    images.push_back(std::move(pixels));
  }
  cv::Mat matrix = cv::Mat::eye(3, 3, CV_64F);  // equal focal lengths, kept by FIX_ASPECT_RATIO
  cv::Mat distortion;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::calibrateCamera(objects, images, cv::Size(setting.width, setting.height), matrix,
                        distortion, rotations, translations,
                        cv::CALIB_FIX_ASPECT_RATIO | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 |
                            cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST);
  } catch (const cv::Exception&) {
    throw InputError(undetermined);
  }
  fit.numbers = {matrix.at<double>(0, 0), matrix.at<double>(1, 1), matrix.at<double>(0, 2),
                 matrix.at<double>(1, 2)};
  if (!std::all_of(fit.numbers.begin(), fit.numbers.end(),
                   [](double n) { return std::isfinite(n); })) {
    throw InputError(undetermined);
  }
  const Rigid projector_from_plane = rigid_of(six_of(rotations[0], translations[0]));
  fit.projector = six_of(projector_from_plane * rigid_of(fit.planes[0]).inverse());
  shorten(fit.numbers);
  shorten(fit.projector);
  for (std::array<double, 6>& plane : fit.planes) shorten(plane);
  return fit;
}

void add_residuals(const Setting& setting, Fit& fit, ceres::Problem& problem) {
  for (std::size_t p = 0; p < setting.planes.size(); ++p) {
    const PlaneView& plane = setting.planes[p];
    for (std::size_t k = 0; k < plane.printed.pixels.size(); ++k) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PrintedCornerResidual, 2, 6>(
              new PrintedCornerResidual{numbers_of(setting.camera), setting.printed_point(plane, k),
                                        plane.printed.pixels[k]}),
          nullptr, fit.planes[p].data());
    }
    const double scale = camera_px_per_projector_px(plane, setting.projected);
    for (std::size_t k = 0; k < plane.projected.pixels.size(); ++k) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ProjectedCornerResidual, 2, lens_numbers, 6, 6>(
              new ProjectedCornerResidual{setting.camera.unproject(plane.projected.pixels[k]),
                                          setting.projector_pixel(plane, k), scale,
                                          pixel_shape(fit.model)}),
          nullptr, fit.numbers.data(), fit.projector.data(), fit.planes[p].data());
    }
  }
}

/// `noise_px` is the scatter of a corner, for the prior on distortion; 0: no prior.
Fit refine(const Setting& setting, const Fit& start, LensModel model, double noise_px = 0.0) {
  Fit fit = start;
  if (pixel_shape(start.model) == PixelShape::square && pixel_shape(model) != PixelShape::square)
    fit.numbers[1] = fit.numbers[0];
  fit.model = model;
  ceres::Problem problem;
  add_residuals(setting, fit, problem);
  if (noise_px > 0.0) {
    add_prior(problem, distortion_prior(noise_px, fit.numbers[0], setting.width, setting.height),
              fit.numbers);
  }
  const bool usable = solve(problem, fit);

  ceres::Covariance covariance({});
  const double* lens = fit.numbers.data();
  const double* pose = fit.projector.data();
  const std::vector<std::pair<const double*, const double*>> wanted{{lens, lens}, {pose, pose}};
  if (!usable || !covariance.Compute(wanted, &problem)) {
    throw InputError(undetermined);
  }
  Eigen::Matrix<double, lens_numbers, lens_numbers, Eigen::RowMajor> lens_block;
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> pose_block;
  covariance.GetCovarianceBlock(lens, lens, lens_block.data());
  covariance.GetCovarianceBlock(pose, pose, pose_block.data());
  const double freedom = static_cast<double>(fit.residuals) - parameter_count(model) - 6.0 -
                         6.0 * static_cast<double>(setting.planes.size());
  const double variance = fit.residual_sum_of_squares / std::max(freedom, 1.0);
  fit.noise_px = std::sqrt(variance);
  fit.covariance = lens_block * variance;
  fit.pose_covariance = pose_block * variance;
  return fit;
}

/// Residuals in projector pixels, and of the printed corners in camera pixels.
void add_views(const Setting& setting, ProjectorCalibration& result) {
  result.views.clear();
  double sum = 0.0;
  double printed_sum = 0.0;
  std::size_t count = 0;
  std::size_t printed_count = 0;
  for (std::size_t p = 0; p < setting.planes.size(); ++p) {
    const PlaneView& plane = setting.planes[p];
    const Rigid& pose = result.station_from_plane[p];
    ViewResidual view;
    view.name = plane.name;
    double view_sum = 0.0;
    for (std::size_t k = 0; k < plane.projected.pixels.size(); ++k) {
      const Eigen::Vector3d point =
          pose * meet_plane(setting.camera, pose, plane.projected.pixels[k]);
      const Eigen::Vector2d pixel = setting.projector_pixel(plane, k);
      view.pixels.push_back(pixel);
      view.residuals.push_back(result.lens.project(result.projector_from_station * point) - pixel);
      view_sum += view.residuals.back().squaredNorm();
    }
    for (std::size_t k = 0; k < plane.printed.pixels.size(); ++k) {
      printed_sum +=
          (setting.camera.project(pose * setting.printed_point(plane, k)) - plane.printed.pixels[k])
              .squaredNorm();
      ++printed_count;
    }
    view.rms_px = std::sqrt(view_sum / static_cast<double>(view.residuals.size()));
    sum += view_sum;
    count += view.residuals.size();
    result.views.push_back(std::move(view));
  }
  result.rms_px = std::sqrt(sum / static_cast<double>(count));
  result.printed_rms_px = std::sqrt(printed_sum / static_cast<double>(printed_count));
}

double projected_rms(const Setting& setting, const Fit& fit) {
  ProjectorCalibration result;
  result.lens = lens_of(fit.numbers, pixel_shape(fit.model), 0, 0);
  result.projector_from_station = rigid_of(fit.projector);
  for (const auto& plane : fit.planes) result.station_from_plane.push_back(rigid_of(plane));
  add_views(setting, result);
  return result.rms_px;
}

/// A fit this bad [px] has a cause that can be named; a fit without the cause is better by so
/// much.
constexpr double bad_rms_px = 1.0;
constexpr double much_better = 4.0;

/// The RMS of a calibration from other corners or fewer planes; none where there is none.
std::optional<double> rms_of(const Setting& setting) {
  try {
    const Fit start = start_with_opencv(setting);
    return projected_rms(setting, refine(setting, start, LensModel::pinhole));
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Names the plane without which a bad fit, or none at all (`rms` infinite), becomes a good one.
void explain(const Setting& setting, double rms) {
  if (setting.planes.size() < 4) return;
  for (std::size_t p = 0; p < setting.planes.size(); ++p) {
    std::vector<PlaneView> others = setting.planes;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(p));
    const auto without = rms_of({setting.camera, setting.printed, setting.projected, others,
                                 setting.width, setting.height});
    if (without && *without < std::min(bad_rms_px, rms / much_better)) {
      throw InputError(setting.planes[p].name +
                       ": this plane does not agree with the others; it moved between its two "
                       "pictures, or its board is turned or misread: photograph it again or take "
                       "it out of calibration.projector_planes in session.json");
    }
  }
}

}  // namespace

Eigen::Vector3d meet_plane(const Lens& lens, const Rigid& camera_from_plane,
                           const Eigen::Vector2d& pixel) {
  const Rigid plane_from_camera = camera_from_plane.inverse();
  const Eigen::Vector3d direction = plane_from_camera.rotation * lens.unproject(pixel);
  const Eigen::Vector3d& eye = plane_from_camera.translation;
  Eigen::Vector3d point = eye - direction * (eye.z() / direction.z());
  point.z() = 0.0;
  return point;
}

Eigen::Vector2d projector_pixel(const capture::ProjectedBoard& projected,
                                const BoardCorners& corners, std::size_t k) {
  const auto [i, j] = corners.place(k);
  return {projected.origin_px[0] + projected.square_px * i,
          projected.origin_px[1] + projected.square_px * j};
}

double camera_px_per_projector_px(const PlaneView& plane,
                                  const capture::ProjectedBoard& projected) {
  const std::vector<Eigen::Vector2d>& seen = plane.projected.pixels;
  const auto count = static_cast<double>(seen.size());
  Eigen::Vector2d seen_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d shown_mean = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < seen.size(); ++k) {
    seen_mean += seen[k] / count;
    shown_mean += projector_pixel(projected, plane.projected, k) / count;
  }
  double seen_square = 0.0;
  double shown_square = 0.0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    seen_square += (seen[k] - seen_mean).squaredNorm();
    shown_square += (projector_pixel(projected, plane.projected, k) - shown_mean).squaredNorm();
  }
  return std::sqrt(seen_square / shown_square);
}

void measure_residuals(const Lens& camera, const capture::Board& printed,
                       const capture::ProjectedBoard& projected,
                       const std::vector<PlaneView>& planes, ProjectorCalibration& projector) {
  add_views({camera, printed, projected, planes}, projector);
}

double projected_board_rms(const Lens& camera, const ProjectorCalibration& projector,
                           const capture::ProjectedBoard& projected,
                           const std::vector<PlaneView>& planes) {
  ProjectorCalibration measured = projector;
  measure_residuals(camera, {}, projected, planes, measured);
  return measured.rms_px;
}

ProjectorCalibration calibrate_projector(const Lens& camera, const capture::Board& printed,
                                         const capture::ProjectedBoard& projected,
                                         const std::vector<PlaneView>& planes, int width,
                                         int height) {
  if (planes.size() < least_views) {
    throw InputError("projector calibration: " + std::to_string(planes.size()) +
                     " planes given and at least 3 are needed (6 or more are good); add entries to "
                     "calibration.projector_planes in session.json");
  }
  const Setting setting{camera, printed, projected, planes, width, height};
  Fit best;
  try {
    best = refine(setting, start_with_opencv(setting), LensModel::pinhole_square);
    // The first pass takes distortion for noise.
    for (int pass = 0; pass < 2; ++pass) {
      best = refine(setting, best, LensModel::radial2_tangential, best.noise_px);
    }
  } catch (const InputError&) {
    explain(setting, std::numeric_limits<double>::infinity());
    throw;
  }
  const double rms = projected_rms(setting, best);
  if (rms > bad_rms_px) explain(setting, rms);
  ProjectorCalibration result;
  result.model = best.model;
  result.lens = lens_of(best.numbers, pixel_shape(best.model), width, height);
  result.covariance = best.covariance;
  result.projector_from_station = rigid_of(best.projector);
  result.pose_covariance = best.pose_covariance;
  result.converged = best.converged;
  for (const auto& plane : best.planes) result.station_from_plane.push_back(rigid_of(plane));
  add_views(setting, result);
  return result;
}

}  // namespace kappamu::calib
