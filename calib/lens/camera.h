// Camera intrinsics from photographs of a printed chessboard in many poses (Zhang 2000), refined by
// least squares over all corners, with the covariance of the result.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/lens/known_lens.h"
#include "calib/lens/lens.h"
#include "calib/targets/board_corners.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// Which of the lens' numbers are estimated; the others stay at 0 (or, for the aspect, fx = fy).
enum class LensModel {
  pinhole_square,      ///< f, cx, cy
  radial1_square,      ///< f, cx, cy, k1
  pinhole,             ///< fx, fy, cx, cy
  radial1,             ///< ... and k1
  radial2,             ///< ... and k1, k2
  radial2_tangential,  ///< ... and k1, k2, p1, p2
  full,                ///< ... and k1, k2, p1, p2, k3
  rational,            ///< ... and k1, k2, p1, p2, k3, k4, k5, k6
  held                 ///< none: a known lens, taken as exact
};
std::string to_string(LensModel model);
int parameter_count(LensModel model);

/// fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6: the order of covariances.
inline constexpr int lens_numbers = 12;
using LensCovariance = Eigen::Matrix<double, lens_numbers, lens_numbers>;

/// One photograph of the board: where its corners appear.
struct BoardView {
  std::string name;  ///< file, for messages and the report
  BoardCorners corners;
};

/// How well a set of corners is explained.
struct ViewResidual {
  std::string name;
  double rms_px = 0.0;                     ///< over the corners in use
  std::vector<Eigen::Vector2d> pixels;     ///< observed corners [px]
  std::vector<Eigen::Vector2d> residuals;  ///< projected - observed [px]
  std::vector<int> left_out;               ///< corners that took no part, as outliers
};

/// What a lens model, with or without a bent board, makes of views it was not fitted to.
struct ModelScore {
  LensModel model = LensModel::pinhole;
  bool bent = false;
  double held_out_rms_px = 0.0;  ///< leave-one-view-out, the view's pose fitted anew
  bool chosen = false;
};

struct CameraCalibration {
  Lens lens;
  LensModel model = LensModel::radial2_tangential;
  /// From the views' scatter (camera_fit.h); rows and columns of what the model holds fixed are 0.
  LensCovariance covariance = LensCovariance::Zero();
  double rms_px =
      0.0;  ///< root of the mean squared distance between corners observed and projected
  std::array<double, 2> bend_mm{};       ///< of the printed board, board_shape.h; 0 where flat
  std::vector<Rigid> camera_from_board;  ///< one per view; corners as in board_shape.h
  std::vector<ViewResidual> views;
  std::vector<ModelScore> scores;  ///< of every model tried; empty where the model was given
  bool converged = false;
  /// Covariance of everything: lens (12), bend (2), then six per view (rotation vector [rad],
  /// translation [mm]). Not stored in files: empty in a calibration that was read.
  Eigen::MatrixXd joint_covariance;
  /// Variance of what a whole view asks of lens and bend over that of independent corners with the
  /// same residuals, at least 1: what neighbouring corners' common errors add.
  double overdispersion = 1.0;

  double standard_deviation(int parameter) const;  ///< index into the order of `covariance`
};

/// Of a camera, and planes of a projector.
inline constexpr std::size_t least_views = 3;

/// Calibrates from at least three views: Zhang's start, least squares over lens and poses, corners
/// further off than six standard deviations (found under Cauchy's loss) left out. Without `model`
/// the lens model and whether the board is bent are chosen by leave-one-view-out cross-validation
/// (camera_choice.h); with it the board is taken as flat. A `known` lens replaces Zhang's start or,
/// held, is the result: the views' poses alone are found then, from one view on. Throws InputError
/// for fewer than three views or views that do not determine the lens.
CameraCalibration calibrate_camera(const std::vector<BoardView>& views, double square_mm, int width,
                                   int height, std::optional<LensModel> model = std::nullopt,
                                   const std::optional<KnownLens>& known = std::nullopt);

/// Sets rms_px and the views' residuals and rms_px from lens, bend and poses.
void measure_residuals(const std::vector<BoardView>& views, double square_mm,
                       CameraCalibration& camera);

/// Pose of one board in a camera already known, over all its corners.
Rigid board_pose(const Lens& lens, const BoardCorners& corners, double square_mm,
                 const std::string& name, const std::array<double, 2>& bend_mm = {});

}  // namespace kappamu::calib
