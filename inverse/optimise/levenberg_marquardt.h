// Least squares of few unknowns, each evaluation of which costs a batch of solves: what the
// homogeneous start, models of layers and the check of scale and shift are fitted by.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace kappamu::inverse {

/// Residuals r of unknowns p.
class Residuals {
 public:
  virtual ~Residuals() = default;
  /// r at p; empty where there is none.
  virtual Eigen::VectorXd residual(const Eigen::VectorXd& p) = 0;
  /// ∂r/∂p at p, where r is known; empty where there is none.
  virtual Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) = 0;
  /// Makes the cheap columns of `jacobian` exact at p, where the last step led or began.
  virtual void set_cheap_columns(const Eigen::VectorXd& /*p*/, Eigen::MatrixXd& /*jacobian*/) {}
  /// r at a p that differs by cheap unknowns alone from that of the last set_cheap_columns().
  virtual Eigen::VectorXd cheap_residual(const Eigen::VectorXd& p) { return residual(p); }
  /// Weights of the squares of r, before each step.
  virtual Eigen::VectorXd weights(const Eigen::VectorXd& residual) {
    return Eigen::VectorXd::Ones(residual.size());
  }
  /// The nearest p that is allowed.
  virtual Eigen::VectorXd bounded(const Eigen::VectorXd& p) const { return p; }
};

/// |rows p − value|², which decides what the residuals leave open.
struct LinearPrior {
  Eigen::MatrixXd rows;
  Eigen::VectorXd value;

  double square(const Eigen::VectorXd& p) const { return (rows * p - value).squaredNorm(); }
};

/// State of a descent.
struct LeastSquaresState {
  Eigen::VectorXd p;
  Eigen::VectorXd residual;  ///< at p; empty before it is known
  Eigen::MatrixXd jacobian;  ///< about p; empty before it is known
};

struct PlannedStep {
  const Eigen::VectorXd& step;
  double cost;      ///< Σ w r² + prior now
  double promised;  ///< decrease of the cost, were r linear
  double hoped;     ///< that of the step before it was cut to the longest allowed
};
enum class Continue { yes, converged, give_up };

struct LevenbergMarquardtOptions {
  int most_steps = 25;
  double longest_step = 1.0;  ///< of any unknown
  int cheap_columns = 0;      ///< the last ones of a Jacobian, which cost no solve
  /// A step that keeps little of its promise is bent back towards the curved minimum line it left,
  /// at the cost of one more evaluation (geodesic acceleration, Transtrum & Sethna 2012), if by
  /// less than this share of its length.
  double most_bend = 0.0;
};

struct LevenbergMarquardtReport {
  int steps = 0;
  bool converged = false;
};

/// JᵀWJ + rowsᵀrows.
Eigen::MatrixXd normal_matrix(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& weight,
                              const LinearPrior& prior);

/// Minimises Σ w r² + prior from at.p, where at.residual must be known, until `next` ends it. The
/// Jacobian is asked for where at.jacobian is empty or a step disappoints; Broyden's update makes
/// it good for the steps between.
LevenbergMarquardtReport levenberg_marquardt(
    Residuals& residuals, const LinearPrior& prior, LeastSquaresState& at,
    const LevenbergMarquardtOptions& options,
    const std::function<Continue(const PlannedStep&)>& next);

}  // namespace kappamu::inverse
