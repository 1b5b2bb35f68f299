#include "inverse/optimise/levenberg_marquardt.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/numbers/linear_algebra.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::levenberg_marquardt;

}  // namespace

Eigen::MatrixXd normal_matrix(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& weight,
                              const LinearPrior& prior) {
  return gram(weight.cwiseSqrt().asDiagonal() * jacobian) + gram(prior.rows);
}

LevenbergMarquardtReport levenberg_marquardt(
    Residuals& residuals, const LinearPrior& prior, LeastSquaresState& at,
    const LevenbergMarquardtOptions& options,
    const std::function<Continue(const PlannedStep&)>& next) {
  LevenbergMarquardtReport report;
  double damping = first_damping;
  double raise = first_raise;
  bool stale = at.jacobian.size() == 0;
  bool fresh = false;
  for (; report.steps < options.most_steps; ++report.steps) {
    const Eigen::VectorXd weight = residuals.weights(at.residual);
    if (stale) {
      at.jacobian = residuals.jacobian(at.p);
      if (at.jacobian.size() == 0) return report;
      fresh = true;
    }
    residuals.set_cheap_columns(at.p, at.jacobian);
    const Eigen::VectorXd slope = at.jacobian.transpose() * weight.cwiseProduct(at.residual) +
                                  prior.rows.transpose() * (prior.rows * at.p - prior.value);
    const Eigen::MatrixXd normal = normal_matrix(at.jacobian, weight, prior);
    Eigen::MatrixXd damped = normal;
    damped.diagonal() += damping * normal.diagonal();
    damped.diagonal().array() += least_damping * normal.trace();
    const Eigen::LDLT<Eigen::MatrixXd> factored(damped);
    const auto cost_of = [&](const Eigen::VectorXd& p, const Eigen::VectorXd& r) {
      return r.cwiseAbs2().dot(weight) + prior.square(p);
    };
    const auto promise_of = [&](const Eigen::VectorXd& move) {
      return -(2.0 * slope.dot(move) + move.dot(normal * move));
    };
    const double cost = cost_of(at.p, at.residual);
    Eigen::VectorXd step = -factored.solve(slope);
    const double hoped = promise_of(step);
    step *= std::min(1.0, options.longest_step / std::max(1e-300, step.cwiseAbs().maxCoeff()));
    step = residuals.bounded(at.p + step) - at.p;
    const double promised = promise_of(step);
    const Continue verdict = next({step, cost, promised, hoped});
    if (verdict != Continue::yes) {
      report.converged = verdict == Continue::converged;
      return report;
    }

    Eigen::VectorXd found = residuals.residual(at.p + step);
    const auto gain_of = [&](const Eigen::VectorXd& move, const Eigen::VectorXd& r) {
      return r.size() > 0 ? cost - cost_of(at.p + move, r)
                          : -std::numeric_limits<double>::infinity();
    };
    double gain = gain_of(step, found);
    if (options.most_bend > 0.0 && gain < kept_well * promised && found.size() > 0) {
      // The unpredicted part of the residual is half the second derivative along the step; the
      // bend cancels it (geodesic acceleration).
      const Eigen::VectorXd unforeseen = found - at.residual - at.jacobian * step;
      const Eigen::VectorXd bend =
          -factored.solve(at.jacobian.transpose() * weight.cwiseProduct(unforeseen));
      if (bend.norm() < options.most_bend * step.norm()) {
        Eigen::VectorXd bent = residuals.residual(at.p + step + bend);
        const double bent_gain = gain_of(step + bend, bent);
        if (bent_gain > gain) {
          gain = bent_gain;
          found = std::move(bent);
          step += bend;
        }
      }
    }
    if (gain > 0.0) {
      // Broyden's update, by what the unknowns that cost solves left unforeseen.
      const Eigen::Index dear = step.size() - options.cheap_columns;
      const double square = step.head(dear).squaredNorm();
      if (square > 0.0) {
        Eigen::VectorXd before = at.residual;
        if (options.cheap_columns > 0) {
          Eigen::VectorXd cheap = at.p;
          cheap.tail(options.cheap_columns) += step.tail(options.cheap_columns);
          before = residuals.cheap_residual(cheap);
        }
        at.jacobian.leftCols(dear) +=
            (found - before - at.jacobian.leftCols(dear) * step.head(dear)) / square *
            step.head(dear).transpose();
      }
      at.p += step;
      at.residual = std::move(found);
      // Nielsen's rule: smooth in how far the promise was kept.
      const double kept = std::min(1.0, gain / promised);
      damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * kept - 1.0, 3));
      raise = first_raise;
    } else {
      damping *= raise;
      raise *= 2.0;
    }
    const bool poor = gain < trusted_step * promised;
    stale = poor && !(fresh && gain <= 0.0);
    fresh = poor && !stale;
  }
  return report;
}

}  // namespace kappamu::inverse
