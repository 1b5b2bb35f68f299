// Least squares over a camera's lens, the board's bend and the pose of every view.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/lens/lens_solver.h"
#include "calib/targets/board_shape.h"

namespace ceres {
class Problem;
namespace internal {
class ResidualBlock;
}
}  // namespace ceres

namespace kappamu::calib {

/// [view][corner] 1 = takes part.
using CornerMask = std::vector<std::vector<std::uint8_t>>;

struct CameraFit : LensFit {
  bool bent = false;
  std::array<double, 2> bend_mm{};
  std::vector<std::array<double, 6>> poses;  ///< camera_from_board as rotation vector, translation
};

/// Squared residuals [px²] of one view under the lens fitted to all others, its pose fitted anew.
struct HeldOutView {
  double square = 0.0;
  int corners = 0;
};

struct CameraSpread {
  Eigen::MatrixXd covariance;   ///< CameraCalibration::joint_covariance
  double overdispersion = 1.0;  ///< CameraCalibration::overdispersion
};

/// The views, and what every fit of them shares.
struct CameraSetting {
  const std::vector<BoardView>& views;
  double square_mm;
  CornerMask mask;
  /// Scatter of a corner per coordinate, for the prior on p1 and p2; 0: no prior.
  double noise_px = 0.0;

  BoardShape board(std::size_t view) const {
    const BoardCorners& corners = views[view].corners;
    return {corners.columns, corners.rows, square_mm, corners.staggered};
  }
};

/// Zhang's closed form and OpenCV's own refinement, with one radial coefficient at most. Throws
/// InputError if OpenCV finds no lens.
CameraFit start_camera(const CameraSetting& setting, int width, int height);

/// Projected minus observed corner of a view under `fit`.
Eigen::Vector2d corner_residual(const CameraSetting& setting, const CameraFit& fit,
                                std::size_t view, std::size_t corner);

/// Whether the board's bend is a number to be found.
enum class Bend { none, free };

class CameraProblem {
 public:
  /// `cauchy_px` > 0 weighs corners further off than that down (Cauchy's loss).
  CameraProblem(const CameraSetting& setting, const CameraFit& start, LensModel model, Bend bend,
                double cauchy_px = 0.0);
  ~CameraProblem();

  /// Minimises; throws InputError if the views do not determine the lens.
  void solve(double tolerance = 1e-12, int max_iterations = 200);

  /// Every view by turns left out, to first order about the solution: with S_v and g_v the view's
  /// normal matrix and gradient in lens and bend, its pose eliminated,
  ///   d = -(S - S_v)⁻¹ (g - g_v),   square = RSS_v + 2 g_v·d + dᵀ S_v d.
  /// tests/calib/lens/camera_choice_test.cpp holds it against calibrations without the view.
  std::vector<HeldOutView> leave_one_out();

  /// Errors of one view's corners are not independent (blur, a board that bends anew), those of
  /// different views are: the covariance Σ of lens and bend comes from the views' scatter, by the
  /// bias-reduced cluster-robust estimator (Bell & McCaffrey 2002),
  ///   Σ = Σ_v d_v d_vᵀ,   d_v = R (I - Rᵀ S_v R)^(-1/2) Rᵀ g_v,   R Rᵀ = S⁻¹,
  /// which for independent corners is σ² S⁻¹ on average, mixed with two views' worth of that form.
  /// Pose v follows them by T_v = -C_v⁻¹ B_vᵀ and has C_v⁻¹ of its own, C_v being its block of JᵀJ
  /// and B_v the one it shares with the lens. Throws InputError if the views do not determine the
  /// lens.
  CameraSpread covariance();

  /// Of one view's residuals (x, y of each corner in use) by the free numbers of lens, bend where
  /// it is free, and pose.
  Eigen::MatrixXd jacobian(std::size_t view, std::vector<double>* residuals = nullptr);

  const CameraFit& fit() const { return fit_; }

 private:
  /// One view's share of the normal equations in the free numbers of lens and bend.
  struct Normal {
    Eigen::MatrixXd matrix;                    ///< S_v
    Eigen::VectorXd gradient;                  ///< g_v
    double square = 0.0;                       ///< Σr² with the pose at its best
    Eigen::MatrixXd follow;                    ///< T_v, 6 x free numbers
    Eigen::Matrix<double, 6, 6> pose_inverse;  ///< C_v⁻¹
  };
  struct Spread {
    Eigen::MatrixXd shared;  ///< covariance of the free numbers of lens and bend
    double overdispersion = 1.0;
  };
  bool has_prior() const;
  Spread spread(const std::vector<Normal>& views, double noise_variance) const;
  std::vector<Normal> normals();
  /// Sum over the views and the prior on p1, p2: matrix and gradient.
  std::pair<Eigen::MatrixXd, Eigen::VectorXd> total(const std::vector<Normal>& views) const;

  const CameraSetting& setting_;
  CameraFit fit_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<std::vector<ceres::internal::ResidualBlock*>> blocks_;  ///< [view]
};

}  // namespace kappamu::calib
