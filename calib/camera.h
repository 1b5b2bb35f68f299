// Camera intrinsics from photographs of a printed chessboard in many poses (Zhang 2000), refined by
// least squares over all corners, with the covariance of the result.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/chessboard.h"
#include "calib/lens.h"
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
  full                 ///< ... and k1, k2, p1, p2, k3
};
std::string to_string(LensModel model);
int parameter_count(LensModel model);

/// One photograph of the board: where its corners appear.
struct BoardView {
  std::string name;  ///< file, for messages and the report
  BoardCorners corners;
};

/// How well a set of corners is explained.
struct ViewResidual {
  std::string name;
  double rms_px = 0.0;
  std::vector<Eigen::Vector2d> pixels;     ///< observed corners [px]
  std::vector<Eigen::Vector2d> residuals;  ///< projected - observed [px]
};

struct CameraCalibration {
  Lens lens;
  LensModel model = LensModel::radial2_tangential;
  /// Covariance of (fx, fy, cx, cy, k1, k2, p1, p2, k3) from the corners' scatter; rows and columns
  /// of what the model holds fixed are 0.
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
  double rms_px =
      0.0;  ///< root of the mean squared distance between corners observed and projected
  std::vector<Rigid> camera_from_board;  ///< one per view; board corners at square * (i, j, 0)
  std::vector<ViewResidual> views;
  bool converged = false;

  double standard_deviation(int parameter) const;  ///< index into the order of `covariance`
};

/// Calibrates from at least three views. Without `model`, starts from one radial coefficient and
/// adds k2, then p1 and p2, where Akaike's criterion says that they help predict new views (a
/// missed p1, p2 shifts the principal point by pixels, an idle one costs nothing); k3 only if the
/// stricter Bayesian criterion agrees (docs/calibration.md). Throws InputError for fewer than three
/// views or views that do not determine the lens.
CameraCalibration calibrate_camera(const std::vector<BoardView>& views, double square_mm, int width,
                                   int height, std::optional<LensModel> model = std::nullopt);

/// Pose of one board in a camera already known, over all its corners.
Rigid board_pose(const Lens& lens, const BoardCorners& corners, double square_mm,
                 const std::string& name);

}  // namespace kappamu::calib
