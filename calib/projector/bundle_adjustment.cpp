#include "calib/projector/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>

#include "calib/lens/camera_fit.h"
#include "calib/lens/lens_solver.h"
#include "calib/lens/normal_equations.h"
#include "calib/lens/pose_numbers.h"
#include "calib/lens/rigid_motion.h"
#include "calib/projector/bundle_numbers.h"
#include "calib/targets/board_shape.h"
#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

template <class T>
using Vector2 = Eigen::Matrix<T, 2, 1>;
template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

constexpr double huber_deviations = 3.0;

double value_of(double x) {
  return x;
}
template <class Jet>
double value_of(const Jet& x) {
  return x.a;
}

/// Lens::unproject for any scalar: one step of Newton's method from the converged point, with the
/// Jacobian held, is exact to first order in the lens' numbers.
template <class T>
Vector3<T> unproject_numbers(const T* numbers, PixelShape pixels, const Eigen::Vector2d& pixel) {
  LensNumbers plain{};
  for (int k = 0; k < lens_numbers; ++k) plain[k] = value_of(numbers[k]);
  const Eigen::Vector3d ray = lens_of(plain, pixels, 0, 0).unproject(pixel);
  const Eigen::Vector2d start = ray.head<2>();
  const Eigen::Matrix2d inverse = distortion_jacobian(plain.data() + 4, start).inverse();
  const Vector2<T> miss = distort<T>(numbers + 4, start.cast<T>()) -
                          Vector2<T>((T(pixel.x()) - numbers[2]) / numbers[0],
                                     (T(pixel.y()) - numbers[3]) /
                                         (pixels == PixelShape::square ? numbers[0] : numbers[1]));
  const Vector2<T> at = start.cast<T>() - inverse.cast<T>() * miss;
  return {at.x(), at.y(), T(1.0)};
}

/// Printed corner; parameters: camera, bend, board's pose.
struct PrintedResidual {
  BoardShape board;
  std::array<int, 2> place;
  Eigen::Vector2d observed;
  double weight;
  PixelShape pixels;

  template <class T>
  bool operator()(const T* camera, const T* bend, const T* pose, T* residual) const {
    const Vector3<T> corner = bent_corner<T>(board, bend, place[0], place[1]);
    const Vector2<T> pixel = project_numbers<T>(camera, pixels, moved<T>(pose, corner));
    residual[0] = weight * (pixel.x() - observed.x());
    residual[1] = weight * (pixel.y() - observed.y());
    return true;
  }
};

/// Projected corner; parameters: camera, projector, projector's pose, plane's pose. `weight` also
/// turns projector pixels into camera pixels.
struct ProjectedResidual {
  Eigen::Vector2d seen;
  Eigen::Vector2d shown;
  double weight;
  PixelShape camera_pixels;
  PixelShape projector_pixels;

  template <class T>
  bool operator()(const T* camera, const T* projector, const T* projector_pose, const T* plane,
                  T* residual) const {
    const Vector3<T> point = met_by(plane, unproject_numbers<T>(camera, camera_pixels, seen));
    const Vector2<T> pixel =
        project_numbers<T>(projector, projector_pixels, moved<T>(projector_pose, point));
    residual[0] = weight * (pixel.x() - shown.x());
    residual[1] = weight * (pixel.y() - shown.y());
    return true;
  }
};

class Adjustment {
 public:
  Adjustment(const JointSetting& setting, const CameraCalibration& camera,
             const ProjectorCalibration& projector)
      : setting_(setting),
        camera_pixels_(pixel_shape(camera.model)),
        projector_pixels_(pixel_shape(projector.model)),
        camera_fixed_(fixed_numbers(camera.model)),
        projector_fixed_(fixed_numbers(projector.model)),
        bent_(camera.bend_mm != std::array<double, 2>{}),
        width_(projector.lens.width),
        height_(projector.lens.height) {
    numbers_.camera = numbers_of(camera.lens);
    numbers_.bend = camera.bend_mm;
    numbers_.projector = numbers_of(projector.lens);
    numbers_.projector_pose = six_of(projector.projector_from_station);
    for (const Rigid& pose : camera.camera_from_board) numbers_.poses.push_back(six_of(pose));
    // The planes were refined with the projector.
    const std::size_t first = numbers_.poses.size() - setting.planes.size();
    for (std::size_t p = 0; p < setting.planes.size(); ++p) {
      numbers_.poses[first + p] = six_of(projector.station_from_plane[p]);
    }
    for (const ViewResidual& view : camera.views) {
      mask_.emplace_back(view.pixels.size(), 1);
      for (const int corner : view.left_out) mask_.back()[static_cast<std::size_t>(corner)] = 0;
    }
  }

  /// Minimises with given scatters of both kinds [px]; false if the result is of no use.
  bool solve(double printed_px, double projected_px) {
    problem_ = std::make_unique<ceres::Problem>();
    printed_.clear();
    projected_.clear();
    add_printed(1.0 / printed_px);
    add_projected(1.0 / projected_px);
    add_prior(*problem_, tangential_prior(1.0), numbers_.camera);
    add_prior(*problem_, distortion_prior(1.0, numbers_.projector[0], width_, height_),
              numbers_.projector);
    hold(*problem_, numbers_.camera.data(), camera_fixed_);
    hold(*problem_, numbers_.projector.data(), projector_fixed_);
    if (!bent_) problem_->SetParameterBlockConstant(numbers_.bend.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.gradient_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    converged_ = summary.termination_type == ceres::CONVERGENCE;
    return summary.IsSolutionUsable();
  }

  double printed_scatter() const { return scatter(printed_); }
  double projected_scatter() const { return scatter(projected_); }

  /// Of all numbers, in the order of JointCalibration; what is held has none.
  Eigen::MatrixXd covariance(double variance_of_unit_weight) const {
    ceres::Problem::EvaluateOptions options;
    std::vector<Eigen::Index> places;
    const auto block = [&](const double* data, Eigen::Index at, int count,
                           const std::vector<int>& fixed) {
      if (fixed.size() == static_cast<std::size_t>(count)) return;
      options.parameter_blocks.push_back(const_cast<double*>(data));
      for (int k = 0; k < count; ++k) {
        if (std::find(fixed.begin(), fixed.end(), k) == fixed.end()) places.push_back(at + k);
      }
    };
    block(numbers_.camera.data(), JointNumbers::camera_at, lens_numbers, camera_fixed_);
    if (bent_) block(numbers_.bend.data(), JointNumbers::bend_at, 2, {});
    block(numbers_.projector.data(), JointNumbers::projector_at, lens_numbers, projector_fixed_);
    block(numbers_.projector_pose.data(), JointNumbers::pose_at, 6, {});
    for (std::size_t v = 0; v < numbers_.poses.size(); ++v) {
      block(numbers_.poses[v].data(), JointNumbers::views_at + 6 * static_cast<Eigen::Index>(v), 6,
            {});
    }
    ceres::CRSMatrix sparse;
    problem_->Evaluate(options, nullptr, nullptr, nullptr, &sparse);
    const Eigen::MatrixXd jacobian = dense(sparse);
    const Inverse inverse = inverse_of(jacobian.transpose() * jacobian);
    if (!inverse.regular) {
      throw InputError(
          "joint calibration: boards and planes do not determine camera and projector together; "
          "add views with the board tilted by 20 to 40 degrees in different directions");
    }
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(numbers_.size(), numbers_.size());
    for (std::size_t a = 0; a < places.size(); ++a) {
      for (std::size_t b = 0; b < places.size(); ++b) {
        all(places[a], places[b]) =
            variance_of_unit_weight *
            inverse.matrix(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      }
    }
    return all;
  }

  const JointNumbers& numbers() const { return numbers_; }
  bool converged() const { return converged_; }

 private:
  /// Standard deviation of one kind's weighted residuals, from their median so that no outlier
  /// counts; with the share of the parameters in its degrees of freedom.
  double scatter(const std::vector<ceres::ResidualBlockId>& blocks) const {
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    options.residual_blocks = blocks;
    std::vector<double> residuals;
    problem_->Evaluate(options, nullptr, &residuals, nullptr, nullptr);
    for (double& value : residuals) value = std::abs(value);
    constexpr double median_of_normal = 0.6745;
    const double rows = 2.0 * static_cast<double>(printed_.size() + projected_.size());
    return upper_median(std::move(residuals)) / median_of_normal /
           std::sqrt(1.0 - free_numbers() / rows);
  }

  double free_numbers() const {
    const int held = static_cast<int>(camera_fixed_.size() + projector_fixed_.size());
    return 2.0 * lens_numbers - held + (bent_ ? 2.0 : 0.0) + 6.0 +
           6.0 * static_cast<double>(numbers_.poses.size());
  }

  void add_printed(double weight) {
    for (std::size_t v = 0; v < setting_.views.size(); ++v) {
      const BoardCorners& corners = setting_.views[v].corners;
      const BoardShape board{corners.columns, corners.rows, setting_.printed.square_mm,
                             corners.staggered};
      for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
        if (mask_[v][k] == 0) continue;
        printed_.push_back(problem_->AddResidualBlock(
            new ceres::AutoDiffCostFunction<PrintedResidual, 2, lens_numbers, 2, 6>(
                new PrintedResidual{board, corners.place(k), corners.pixels[k], weight,
                                    camera_pixels_}),
            new ceres::HuberLoss(huber_deviations), numbers_.camera.data(), numbers_.bend.data(),
            numbers_.poses[v].data()));
      }
    }
  }

  void add_projected(double weight) {
    const std::size_t first = numbers_.poses.size() - setting_.planes.size();
    for (std::size_t p = 0; p < setting_.planes.size(); ++p) {
      const PlaneView& plane = setting_.planes[p];
      const double scale = camera_px_per_projector_px(plane, setting_.projected);
      for (std::size_t k = 0; k < plane.projected.pixels.size(); ++k) {
        projected_.push_back(problem_->AddResidualBlock(
            new ceres::AutoDiffCostFunction<ProjectedResidual, 2, lens_numbers, lens_numbers, 6, 6>(
                new ProjectedResidual{plane.projected.pixels[k],
                                      projector_pixel(setting_.projected, plane.projected, k),
                                      weight * scale, camera_pixels_, projector_pixels_}),
            new ceres::HuberLoss(huber_deviations), numbers_.camera.data(),
            numbers_.projector.data(), numbers_.projector_pose.data(),
            numbers_.poses[first + p].data()));
      }
    }
  }

  const JointSetting& setting_;
  PixelShape camera_pixels_;
  PixelShape projector_pixels_;
  std::vector<int> camera_fixed_;
  std::vector<int> projector_fixed_;
  bool bent_;
  int width_;  ///< of the projector
  int height_;
  JointNumbers numbers_;
  std::vector<std::vector<std::uint8_t>> mask_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<ceres::ResidualBlockId> printed_;
  std::vector<ceres::ResidualBlockId> projected_;
  bool converged_ = false;
};

}  // namespace

JointCalibration adjust_jointly(const JointSetting& setting, const CameraCalibration& camera,
                                const ProjectorCalibration& projector) {
  check(setting.views.size() >= setting.planes.size() &&
            camera.camera_from_board.size() == setting.views.size() &&
            projector.station_from_plane.size() == setting.planes.size(),
        "adjust_jointly wants the calibrations of these views and planes");
  Adjustment adjustment(setting, camera, projector);
  double printed_px = camera.rms_px / std::sqrt(2.0);
  double projected_px = printed_px;
  constexpr int passes = 3;  // of the weights
  for (int pass = 0; pass < passes; ++pass) {
    if (!adjustment.solve(printed_px, projected_px)) {
      throw InputError(
          "joint calibration: camera and projector do not go together; calibrate with more views");
    }
    if (pass + 1 == passes) break;
    // Corners without noise (in tests) must not weigh infinitely.
    constexpr double smallest_px = 1e-6;
    printed_px = std::max(smallest_px, printed_px * adjustment.printed_scatter());
    projected_px = std::max(smallest_px, projected_px * adjustment.projected_scatter());
  }
  const JointNumbers& numbers = adjustment.numbers();
  JointCalibration joint;
  joint.converged = adjustment.converged();
  // The corners' common errors widen it as they do the camera's own.
  joint.covariance = adjustment.covariance(camera.overdispersion);

  joint.camera = camera;
  CameraCalibration& eye = joint.camera;
  eye.lens =
      lens_of(numbers.camera, pixel_shape(camera.model), camera.lens.width, camera.lens.height);
  eye.bend_mm = numbers.bend;
  eye.covariance = joint.covariance.topLeftCorner<lens_numbers, lens_numbers>();
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < numbers.size(); ++k) {
    if (k < JointNumbers::projector_at || k >= JointNumbers::views_at) kept.push_back(k);
  }
  eye.joint_covariance = joint.covariance(kept, kept);
  for (std::size_t v = 0; v < setting.views.size(); ++v) {
    eye.camera_from_board[v] = rigid_of(numbers.poses[v]);
  }
  measure_residuals(setting.views, setting.printed.square_mm, eye);

  joint.projector = projector;
  ProjectorCalibration& light = joint.projector;
  light.lens = lens_of(numbers.projector, pixel_shape(projector.model), projector.lens.width,
                       projector.lens.height);
  light.covariance = joint.covariance.block<lens_numbers, lens_numbers>(JointNumbers::projector_at,
                                                                        JointNumbers::projector_at);
  light.projector_from_station = rigid_of(numbers.projector_pose);
  light.pose_covariance =
      joint.covariance.block<6, 6>(JointNumbers::pose_at, JointNumbers::pose_at);
  light.converged = joint.converged;
  const std::size_t first = numbers.poses.size() - setting.planes.size();
  for (std::size_t p = 0; p < setting.planes.size(); ++p) {
    light.station_from_plane[p] = rigid_of(numbers.poses[first + p]);
  }
  measure_residuals(eye.lens, setting.printed, setting.projected, setting.planes, light);
  return joint;
}

bool agrees(const JointCalibration& joint, const CameraCalibration& camera) {
  constexpr double largest_rise = 1.1;
  return joint.camera.rms_px <= largest_rise * camera.rms_px;
}

}  // namespace kappamu::calib
