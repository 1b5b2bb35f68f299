#include "calib/lens/camera_fit.h"

#include <ceres/ceres.h>

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>

#include "calib/lens/lens_model.h"
#include "calib/lens/normal_equations.h"
#include "calib/lens/opencv_convert.h"
#include "calib/targets/board_picture.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"

namespace kappamu::calib {
namespace {

const char* const undetermined =
    "camera calibration: the board photographs do not determine the lens; add views with the board "
    "tilted by 20 to 40 degrees in different directions and filling the frame";

/// Projected minus observed corner; parameters: LensNumbers, bend, camera_from_board as rotation
/// vector and translation. Derivatives by hand: five times quicker than automatic ones with twenty
/// partials (tests/calib/lens/camera_fit_test.cpp holds them against differences).
class CornerCost : public ceres::SizedCostFunction<2, lens_numbers, 2, 6> {
 public:
  CornerCost(const BoardShape& board, int i, int j, const Eigen::Vector2d& observed,
             PixelShape pixels)
      : observed_(observed), pixels_(pixels) {
    constexpr std::array<double, 2> flat{};
    flat_ = bent_corner<double>(board, flat.data(), i, j);
    for (int k = 0; k < 2; ++k) {
      std::array<double, 2> unit{};
      unit[k] = 1.0;
      rise_[k] = bent_corner<double>(board, unit.data(), i, j).z();
    }
  }

  bool Evaluate(const double* const* parameters, double* residual,
                double** jacobians) const override {
    const double* n = parameters[0];
    const double* bend = parameters[1];
    const double* pose = parameters[2];
    using Jet = ceres::Jet<double, 3>;
    const std::array<Jet, 3> turn{Jet(pose[0], 0), Jet(pose[1], 1), Jet(pose[2], 2)};
    const Eigen::Vector3d corner =
        flat_ + Eigen::Vector3d(0.0, 0.0, rise_[0] * bend[0] + rise_[1] * bend[1]);
    const std::array<Jet, 3> fixed{Jet(corner.x()), Jet(corner.y()), Jet(corner.z())};
    std::array<Jet, 3> turned;
    ceres::AngleAxisRotatePoint(turn.data(), fixed.data(), turned.data());
    const Eigen::Vector3d point(turned[0].a + pose[3], turned[1].a + pose[4],
                                turned[2].a + pose[5]);
    const double fx = n[0];
    const double fy = pixels_ == PixelShape::square ? n[0] : n[1];
    const Eigen::Vector2d normalised(point.x() / point.z(), point.y() / point.z());
    const Eigen::Vector2d bent = distort<double>(n + 4, normalised);
    residual[0] = fx * bent.x() + n[2] - observed_.x();
    residual[1] = fy * bent.y() + n[3] - observed_.y();
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) by_lens(n, fx, fy, normalised, bent, jacobians[0]);
    if (jacobians[1] == nullptr && jacobians[2] == nullptr) return true;
    Eigen::Matrix<double, 2, 3> perspective;
    perspective << 1.0, 0.0, -normalised.x(), 0.0, 1.0, -normalised.y();
    const Eigen::Matrix<double, 2, 3> by_point = Eigen::Vector2d(fx, fy).asDiagonal() *
                                                 distortion_jacobian(n + 4, normalised) *
                                                 perspective / point.z();
    if (jacobians[1] != nullptr) {
      const std::array<double, 3> up{0.0, 0.0, 1.0};
      Eigen::Vector3d axis;
      ceres::AngleAxisRotatePoint(pose, up.data(), axis.data());
      const Eigen::Vector2d by_rise = by_point * axis;
      Eigen::Map<Eigen::Matrix<double, 2, 2, Eigen::RowMajor>> out(jacobians[1]);
      out << by_rise * rise_[0], by_rise * rise_[1];
    }
    if (jacobians[2] != nullptr) {
      Eigen::Matrix3d by_turn;
      for (int k = 0; k < 3; ++k) by_turn.row(k) = turned[k].v.transpose();
      Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> out(jacobians[2]);
      out << by_point * by_turn, by_point;
    }
    return true;
  }

 private:
  void by_lens(const double* n, double fx, double fy, const Eigen::Vector2d& normalised,
               const Eigen::Vector2d& bent, double* jacobian) const {
    const double x = normalised.x();
    const double y = normalised.y();
    const double r2 = normalised.squaredNorm();
    const double below = 1.0 + r2 * (n[9] + r2 * (n[10] + r2 * n[11]));
    const double radial = (1.0 + r2 * (n[4] + r2 * (n[5] + r2 * n[8]))) / below;
    Eigen::Map<Eigen::Matrix<double, 2, lens_numbers, Eigen::RowMajor>> out(jacobian);
    out.setZero();
    out(0, 0) = bent.x();
    out(1, pixels_ == PixelShape::square ? 0 : 1) = bent.y();
    out(0, 2) = 1.0;
    out(1, 3) = 1.0;
    const Eigen::Vector2d radially = Eigen::Vector2d(fx * x, fy * y) * r2 / below;
    out.col(4) = radially;
    out.col(5) = radially * r2;
    out.col(6) << fx * 2.0 * x * y, fy * (r2 + 2.0 * y * y);
    out.col(7) << fx * (r2 + 2.0 * x * x), fy * 2.0 * x * y;
    out.col(8) = radially * r2 * r2;
    out.col(9) = -radially * radial;
    out.col(10) = -radially * radial * r2;
    out.col(11) = -radially * radial * r2 * r2;
  }

  Eigen::Vector2d observed_;
  PixelShape pixels_;
  Eigen::Vector3d flat_;
  std::array<double, 2> rise_{};  ///< of the corner for 1 mm of bend
};

constexpr int first_tangential = 6;  // p1 and p2 among the lens' numbers

}  // namespace

CameraFit start_camera(const CameraSetting& setting, int width, int height) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardView& view : setting.views) {
    objects.push_back(board_points(view.corners, setting.square_mm));
    images.push_back(image_points(view.corners.pixels));
  }
  cv::Mat matrix;
  cv::Mat distortion;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::calibrateCamera(objects, images, cv::Size(width, height), matrix, distortion, rotations,
                        translations,
                        cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST,
                        cv::TermCriteria(cv::TermCriteria::COUNT, 10, 0.0));  // a start is enough
  } catch (const cv::Exception&) {
    throw InputError(undetermined);
  }
  CameraFit fit;
  fit.numbers = {matrix.at<double>(0, 0), matrix.at<double>(1, 1), matrix.at<double>(0, 2),
                 matrix.at<double>(1, 2), distortion.at<double>(0)};
  if (!std::all_of(fit.numbers.begin(), fit.numbers.end(),
                   [](double n) { return std::isfinite(n); })) {
    throw InputError(undetermined);
  }
  for (std::size_t v = 0; v < setting.views.size(); ++v) {
    fit.poses.push_back(six_of(rotations[v], translations[v]));
    shorten(fit.poses.back());
  }
  shorten(fit.numbers);
  return fit;
}

Eigen::Vector2d corner_residual(const CameraSetting& setting, const CameraFit& fit,
                                std::size_t view, std::size_t corner) {
  Eigen::Vector2d residual;
  const BoardCorners& corners = setting.views[view].corners;
  const auto [i, j] = corners.place(corner);
  const CornerCost cost(setting.board(view), i, j, corners.pixels[corner], pixel_shape(fit.model));
  const std::array<const double*, 3> parameters{fit.numbers.data(), fit.bend_mm.data(),
                                                fit.poses[view].data()};
  cost.Evaluate(parameters.data(), residual.data(), nullptr);
  return residual;
}

CameraProblem::CameraProblem(const CameraSetting& setting, const CameraFit& start, LensModel model,
                             Bend bend, double cauchy_px)
    : setting_(setting),
      fit_(start),
      problem_(std::make_unique<ceres::Problem>()),
      blocks_(setting.views.size()) {
  fit_.model = model;
  fit_.bent = bend == Bend::free;
  for (std::size_t v = 0; v < setting.views.size(); ++v) {
    const BoardCorners& corners = setting.views[v].corners;
    for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
      if (setting.mask[v][k] == 0) continue;
      const auto [i, j] = corners.place(k);
      auto* cost = new CornerCost(setting.board(v), i, j, corners.pixels[k], pixel_shape(model));
      blocks_[v].push_back(problem_->AddResidualBlock(
          cost, cauchy_px > 0.0 ? new ceres::CauchyLoss(cauchy_px) : nullptr, fit_.numbers.data(),
          fit_.bend_mm.data(), fit_.poses[v].data()));
    }
  }
  if (!fit_.bent) problem_->SetParameterBlockConstant(fit_.bend_mm.data());
  if (has_prior()) {
    add_prior(*problem_, tangential_prior(setting.noise_px), fit_.numbers);
  }
}

CameraProblem::~CameraProblem() = default;

bool CameraProblem::has_prior() const {
  return setting_.noise_px > 0.0 &&
         parameter_count(fit_.model) >= parameter_count(LensModel::radial2_tangential);
}

void CameraProblem::solve(double tolerance, int max_iterations) {
  if (!calib::solve(*problem_, fit_, tolerance, max_iterations)) throw InputError(undetermined);
}

Eigen::MatrixXd CameraProblem::jacobian(std::size_t view, std::vector<double>* residuals) {
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = blocks_[view];
  if (fit_.model != LensModel::held) options.parameter_blocks.push_back(fit_.numbers.data());
  if (fit_.bent) options.parameter_blocks.push_back(fit_.bend_mm.data());
  options.parameter_blocks.push_back(fit_.poses[view].data());
  ceres::CRSMatrix sparse;
  problem_->Evaluate(options, nullptr, residuals, nullptr, &sparse);
  return dense(sparse);
}

std::vector<CameraProblem::Normal> CameraProblem::normals() {
  std::vector<Normal> result;
  for (std::size_t v = 0; v < blocks_.size(); ++v) {
    std::vector<double> residuals;
    const Eigen::MatrixXd by_all = jacobian(v, &residuals);
    const Eigen::Map<const Eigen::VectorXd> r(residuals.data(),
                                              static_cast<Eigen::Index>(residuals.size()));
    const Eigen::MatrixXd shared = by_all.leftCols(by_all.cols() - 6);
    const Eigen::MatrixXd pose = by_all.rightCols(6);
    const Eigen::MatrixXd back = pose.transpose();
    Normal normal;
    normal.pose_inverse = solve_symmetric(back * pose, Eigen::MatrixXd::Identity(6, 6));
    normal.follow = -normal.pose_inverse * (back * shared);
    const Eigen::MatrixXd left = shared + pose * normal.follow;
    const Eigen::VectorXd rest = r - pose * (normal.pose_inverse * (back * r));
    normal.matrix = left.transpose() * left;
    normal.gradient = left.transpose() * rest;
    normal.square = rest.squaredNorm();
    result.push_back(std::move(normal));
  }
  return result;
}

std::pair<Eigen::MatrixXd, Eigen::VectorXd> CameraProblem::total(
    const std::vector<Normal>& views) const {
  Eigen::MatrixXd matrix = views[0].matrix;
  Eigen::VectorXd gradient = views[0].gradient;
  for (std::size_t v = 1; v < views.size(); ++v) {
    matrix += views[v].matrix;
    gradient += views[v].gradient;
  }
  if (!has_prior()) return {matrix, gradient};
  const double weight = std::pow(setting_.noise_px / tangential_spread, 2);
  for (int k = first_tangential; k < first_tangential + 2; ++k) {
    matrix(k, k) += weight;
    gradient[k] += weight * fit_.numbers[static_cast<std::size_t>(k)];
  }
  return {matrix, gradient};
}

std::vector<HeldOutView> CameraProblem::leave_one_out() {
  const std::vector<Normal> views = normals();
  const auto [matrix, gradient] = total(views);
  std::vector<HeldOutView> held_out;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Normal& own = views[v];
    const Eigen::VectorXd step =
        -(inverse_of(matrix - own.matrix).matrix * (gradient - own.gradient));
    held_out.push_back({own.square + 2.0 * own.gradient.dot(step) + step.dot(own.matrix * step),
                        static_cast<int>(blocks_[v].size())});
  }
  return held_out;
}

CameraProblem::Spread CameraProblem::spread(const std::vector<Normal>& views,
                                            double noise_variance) const {
  if (fit_.model == LensModel::held) return {};  // nothing is shared
  const Inverse inverse = inverse_of(total(views).first);
  if (!inverse.regular) throw InputError(undetermined);
  const Eigen::MatrixXd& bread = inverse.matrix;
  const SymmetricEigen roots = symmetric_eigen(bread);
  const Eigen::MatrixXd root = roots.vectors * roots.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  double found = 0.0;
  double expected = 0.0;
  Eigen::MatrixXd by_views = Eigen::MatrixXd::Zero(bread.rows(), bread.cols());
  for (const Normal& view : views) {
    const SymmetricEigen own = symmetric_eigen(root.transpose() * view.matrix * root);
    constexpr double least_left = 1e-3;  // of a direction that this view alone determines
    const Eigen::VectorXd left = (1.0 - own.values.array()).max(least_left);
    const Eigen::VectorXd score = own.vectors.transpose() * (root.transpose() * view.gradient);
    found += score.squaredNorm();
    expected += noise_variance * own.values.dot(left);
    const Eigen::VectorXd moved = root * (own.vectors * score.cwiseQuotient(left.cwiseSqrt()));
    by_views += moved * moved.transpose();
  }
  Spread spread;
  spread.overdispersion = std::max(1.0, found / std::max(expected, 1e-300));
  // As many views as this that err alike in every direction keep few views from knowing some
  // direction by chance.
  constexpr double alike = 2.0;
  const double count = static_cast<double>(views.size()) - 1.0;
  spread.shared =
      (count * by_views + alike * spread.overdispersion * noise_variance * bread) / (count + alike);
  return spread;
}

CameraSpread CameraProblem::covariance() {
  const std::vector<Normal> views = normals();
  // Where each free number goes among lens (12) and bend (2).
  std::vector<Eigen::Index> place;
  const std::vector<int> fixed = fixed_numbers(fit_.model);
  for (int k = 0; k < lens_numbers + (fit_.bent ? 2 : 0); ++k) {
    if (std::find(fixed.begin(), fixed.end(), k) == fixed.end()) place.push_back(k);
  }
  Eigen::MatrixXd of_free =
      Eigen::MatrixXd::Zero(lens_numbers + 2, static_cast<Eigen::Index>(place.size()));
  for (std::size_t k = 0; k < place.size(); ++k)
    of_free(place[k], static_cast<Eigen::Index>(k)) = 1;
  const double freedom = static_cast<double>(fit_.residuals) - static_cast<double>(place.size()) -
                         6.0 * static_cast<double>(views.size());
  const double noise_variance = fit_.residual_sum_of_squares / std::max(freedom, 1.0);
  const Spread found = spread(views, noise_variance);

  constexpr Eigen::Index shared = lens_numbers + 2;
  const Eigen::Index size = shared + 6 * static_cast<Eigen::Index>(views.size());
  Eigen::MatrixXd follow(size, of_free.cols());
  follow.topRows<shared>() = of_free;
  for (std::size_t v = 0; v < views.size(); ++v) {
    follow.middleRows<6>(shared + 6 * static_cast<Eigen::Index>(v)) = views[v].follow;
  }
  CameraSpread result{propagated(follow, found.shared), found.overdispersion};
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Eigen::Index at = shared + 6 * static_cast<Eigen::Index>(v);
    result.covariance.block<6, 6>(at, at) +=
        found.overdispersion * noise_variance * views[v].pose_inverse;
  }
  return result;
}

}  // namespace kappamu::calib
