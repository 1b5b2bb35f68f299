#include "calib/sample/pose_fit.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>

#include "calib/lens/opencv_convert.h"
#include "calib/lens/rigid_motion.h"

namespace kappamu::calib {
namespace {

/// Distance in pixels of an edge point's ray from the plane through the eye and an edge, measured
/// in the undistorted image.
struct EdgeResidual {
  Eigen::Vector3d ray;  ///< z = 1
  Eigen::Vector3d start;
  Eigen::Vector3d end;
  double focal_px;

  template <class T>
  bool operator()(const T* pose, T* residual) const {
    const Eigen::Matrix<T, 3, 1> line =
        moved<T>(pose, start.cast<T>()).cross(moved<T>(pose, end.cast<T>()));
    const Eigen::Matrix<T, 3, 1> direction = ray.cast<T>();
    residual[0] = focal_px * line.dot(direction) / line.template head<2>().norm();
    return true;
  }
};

struct CornerResidual {
  Eigen::Vector3d ray;  ///< z = 1
  Eigen::Vector3d corner;
  double focal_px;

  template <class T>
  bool operator()(const T* pose, T* residual) const {
    const Eigen::Matrix<T, 3, 1> point = moved<T>(pose, corner.cast<T>());
    residual[0] = focal_px * (point.x() / point.z() - ray.x());
    residual[1] = focal_px * (point.y() / point.z() - ray.y());
    return true;
  }
};

double focal(const Lens& lens) {
  return 0.5 * (lens.fx + lens.fy);
}

/// How many residuals in a row count as one: 1 + 2 Σ ρ_k over the first lags, with ρ_k the
/// correlation along an edge. Edge points lie a pixel apart and each is a centroid over seven.
double correlation_length(const std::vector<double>& residuals) {
  constexpr std::size_t lags = 8;
  const std::size_t n = residuals.size();
  double variance = 0.0;
  for (const double r : residuals) variance += r * r;
  if (variance <= 0.0 || n <= lags) return 1.0;
  double length = 1.0;
  for (std::size_t lag = 1; lag <= lags; ++lag) {
    double product = 0.0;
    for (std::size_t k = 0; k + lag < n; ++k) product += residuals[k] * residuals[k + lag];
    // Newey & West 1987: weights that keep the sum positive.
    length += 2.0 * (1.0 - static_cast<double>(lag) / (lags + 1.0)) * product / variance;
  }
  return std::max(1.0, length);
}

/// Solves and adds RMS (of residual blocks) and covariance.
Refined solve(ceres::Problem& problem, Six& pose) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Refined result;
  result.pose = pose;
  if (!summary.IsSolutionUsable() || pose[5] <= 0.0) return result;
  result.cost = summary.final_cost;
  std::vector<double> residuals;
  ceres::Problem::EvaluateOptions plain;
  plain.apply_loss_function = false;
  problem.Evaluate(plain, nullptr, &residuals, nullptr, nullptr);
  double sum = 0.0;
  for (const double r : residuals) sum += r * r;
  result.rms_px = std::sqrt(sum / problem.NumResidualBlocks());
  ceres::Covariance covariance({});
  const std::vector<std::pair<const double*, const double*>> wanted{{pose.data(), pose.data()}};
  if (covariance.Compute(wanted, &problem)) {
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> block;
    covariance.GetCovarianceBlock(pose.data(), pose.data(), block.data());
    const double freedom = std::max(1.0, static_cast<double>(residuals.size()) - 6.0);
    result.covariance =
        block * (2.0 * summary.final_cost / freedom * correlation_length(residuals));
  }
  return result;
}

}  // namespace

Six within_half_turn(const Six& pose) {
  return six_of(rigid_of(pose));
}

std::vector<Six> planar_poses(const Corners& corners_px, const Lens& lens,
                              const Corners3& corners) {
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> images;
  for (std::size_t k = 0; k < 4; ++k) {
    objects.emplace_back(corners[k].x(), corners[k].y(), corners[k].z());
    const Eigen::Vector3d ray = lens.unproject(corners_px[k]);
    images.emplace_back(ray.x(), ray.y());
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<Six> poses;
  try {
    cv::solvePnPGeneric(objects, images, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations,
                        translations, false, cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return poses;
  }
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    poses.push_back(six_of(rotations[k], translations[k]));
  }
  return poses;
}

Refined refine_on_corners(const Corners& corners_px, const Lens& lens, const Corners3& corners,
                          Six pose) {
  ceres::Problem problem;
  for (std::size_t k = 0; k < 4; ++k) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<CornerResidual, 2, 6>(
            new CornerResidual{lens.unproject(corners_px[k]), corners[k], focal(lens)}),
        nullptr, pose.data());
  }
  return solve(problem, pose);
}

Refined refine_on_edges(const std::vector<std::vector<Eigen::Vector2d>>& edges, const Lens& lens,
                        const Corners3& corners, Six pose) {
  constexpr double cauchy_px = 0.3;  // a few times the scatter of a clean edge
  ceres::Problem problem;
  for (std::size_t k = 0; k < 4; ++k) {
    for (const Eigen::Vector2d& pixel : edges[k]) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<EdgeResidual, 1, 6>(new EdgeResidual{
              lens.unproject(pixel), corners[k], corners[(k + 1) % 4], focal(lens)}),
          new ceres::CauchyLoss(cauchy_px), pose.data());
    }
  }
  return solve(problem, pose);
}

}  // namespace kappamu::calib
