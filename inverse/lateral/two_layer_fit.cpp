#include "inverse/lateral/two_layer_fit.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>

#include "core/numbers/linear_algebra.h"
#include "inverse/optimise/levenberg_marquardt.h"

namespace kappamu::inverse {

namespace {

const double prior_deviation = std::log(4.0);
constexpr double most_extreme = 12.0;  // of a logarithm

class TwoLayerResidual final : public Residuals {
 public:
  TwoLayerResidual(const forward::LayeredTransport& transport, double thickness_mm,
                   const PerFrequency& frequency, const PerFrequency& reflectance,
                   const Eigen::MatrixXd& covariance)
      : transport_(transport),
        thickness_(thickness_mm),
        frequency_(frequency),
        data_(reflectance.array().log()),
        root_(covariance.llt()) {}

  Eigen::VectorXd residual(const Eigen::VectorXd& p) override {
    if (p.cwiseAbs().maxCoeff() > most_extreme) return {};
    const Eigen::VectorXd c = p.array().exp();
    const std::array<forward::TransportLayer, 2> layers{
        {{c[0], c[1], thickness_}, {c[2], c[3], std::numeric_limits<double>::infinity()}}};
    Eigen::VectorXd difference(frequency_.size());
    for (Eigen::Index i = 0; i < frequency_.size(); ++i) {
      const double light = transport_(layers, frequency_[i]).reflectance;
      if (!(light > 0.0)) return {};
      difference[i] = std::log(light) - data_[i];
    }
    return root_.matrixL().solve(difference);
  }

  Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) override {
    constexpr double step = 1e-3;
    Eigen::MatrixXd result(frequency_.size(), p.size());
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      const Eigen::VectorXd move = step * Eigen::VectorXd::Unit(p.size(), k);
      const Eigen::VectorXd up = residual(p + move), down = residual(p - move);
      if (up.size() == 0 || down.size() == 0) return {};
      result.col(k) = (up - down) / (2.0 * step);
    }
    return result;
  }

 private:
  const forward::LayeredTransport& transport_;
  double thickness_;
  Eigen::VectorXd frequency_, data_;
  Eigen::LLT<Eigen::MatrixXd> root_;
};

}  // namespace

bool TwoLayerFit::determined(Eigen::Index coefficient) const {
  return std::sqrt(covariance(coefficient, coefficient)) < 0.5 * prior_deviation;
}

TwoLayerFit fit_two_layers(const forward::LayeredTransport& transport, double thickness_mm,
                           const PerFrequency& frequency, const PerFrequency& reflectance,
                           const Eigen::MatrixXd& covariance, const LateralCoefficients& start) {
  TwoLayerResidual residual(transport, thickness_mm, frequency, reflectance, covariance);
  const Eigen::Vector4d from(std::log(start.mua), std::log(start.musp), std::log(start.mua),
                             std::log(start.musp));
  const LinearPrior prior{Eigen::Matrix4d::Identity() / prior_deviation, from / prior_deviation};
  LeastSquaresState at{from, residual.residual(from), {}};
  TwoLayerFit fit;
  if (at.residual.size() == 0) return fit;
  constexpr double small_step = 1e-4;
  fit.converged =
      levenberg_marquardt(residual, prior, at, {.most_steps = 60}, [](const PlannedStep& planned) {
        return planned.step.cwiseAbs().maxCoeff() < small_step ? Continue::converged
                                                               : Continue::yes;
      }).converged;
  const Eigen::Vector4d found = at.p.array().exp();
  fit.upper = {found[0], found[1]};
  fit.lower = {found[2], found[3]};
  fit.chi_square = at.residual.squaredNorm();
  const Eigen::MatrixXd jacobian = residual.jacobian(at.p);
  if (jacobian.rows() == 0) {
    fit.converged = false;
    return fit;
  }
  fit.covariance = solve_symmetric(gram(jacobian) + gram(prior.rows), Eigen::Matrix4d::Identity());
  return fit;
}

}  // namespace kappamu::inverse
