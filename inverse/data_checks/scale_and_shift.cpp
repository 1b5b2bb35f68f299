#include "inverse/data_checks/scale_and_shift.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "inverse/block_model/model_evidence.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/defaults.h"
#include "inverse/optimise/levenberg_marquardt.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::scale_and_shift;

class Exposure final : private Residuals {
 public:
  Exposure(Objective& objective, const LayeredMedium& start)
      : objective_(objective),
        face_(objective.problem().seen_shape()),
        start_(start),
        layers_(start.layers()),
        prior_(layer_prior(start)) {
    const Problem& problem = objective.problem();
    for (std::size_t i = 0; i < problem.data.size(); ++i) {
      const double d = problem.data[i];
      const double w = problem.weight[i];
      if (w <= 0.0 || d * std::sqrt(w) <= 3.0) continue;
      used_.push_back(i);
      log_data_.push_back(std::log(d));
      noise_.push_back(1.0 / (w * d * d));
    }
    if (used_.empty()) throw InputError("no datum stands three standard deviations above zero");
    at_.p = Eigen::VectorXd::Zero(2 * layers_ + 3);
    at_.p.head(2 * layers_) = unknowns(start);
    const Eigen::Index rows = prior_.rows.rows();
    prior_.rows.conservativeResizeLike(Eigen::MatrixXd::Zero(rows + 3, at_.p.size()));
    prior_.rows(rows, 2 * layers_) = 1.0 / scale_spread;
    prior_.rows(rows + 1, 2 * layers_ + 1) = 1.0 / (free_shift_spread * face_.nu);
    prior_.rows(rows + 2, 2 * layers_ + 2) = 1.0 / (free_shift_spread * face_.nv);
    prior_.value.conservativeResizeLike(Eigen::VectorXd::Zero(rows + 3));
  }

  CoefficientPair fields() const { return fields(medium(at_.p)); }

  /// Continues from the end of the last call. Its Jacobian is reused: another r changes it little.
  ExposureFit run(const ModelError& model_error) {
    at_.residual = residual(at_.p);
    if (at_.residual.size() == 0) throw InputError("the diffusion solver fails at the start");
    const auto next = [](const PlannedStep& planned) {
      return planned.step.cwiseAbs().maxCoeff() < step_tolerance ? Continue::converged
                                                                 : Continue::yes;
    };
    ExposureFit fit;
    fit.converged = levenberg_marquardt(*this, prior_, at_, {.cheap_columns = 3}, next).converged;
    set_cheap_columns(at_.p, at_.jacobian);
    conclude(model_error, fit);
    return fit;
  }

 private:
  Eigen::VectorXd bounded(const Eigen::VectorXd& p) const override {
    Eigen::VectorXd in = p;
    const Eigen::Vector3d most(largest_log_scale, largest_shift * face_.nu,
                               largest_shift * face_.nv);
    in.tail(3) = p.tail(3).cwiseMax(-most).cwiseMin(most);
    return in;
  }

  /// `map` [M][v][u] at pixel i, moved by the shift; linear between pixels, constant beyond them.
  double shifted(const std::vector<double>& map, std::size_t i, double du, double dv) const {
    const std::size_t cells = face_.cells();
    const std::size_t pattern = i / cells;
    const auto v = static_cast<int>((i % cells) / static_cast<std::size_t>(face_.nu));
    const auto u = static_cast<int>((i % cells) % static_cast<std::size_t>(face_.nu));
    const double at_u = std::clamp(u - du, 0.0, face_.nu - 1.0);
    const double at_v = std::clamp(v - dv, 0.0, face_.nv - 1.0);
    const int u0 = std::min(static_cast<int>(at_u), std::max(0, face_.nu - 2));
    const int v0 = std::min(static_cast<int>(at_v), std::max(0, face_.nv - 2));
    const int u1 = std::min(u0 + 1, face_.nu - 1);
    const int v1 = std::min(v0 + 1, face_.nv - 1);
    const auto value = [&](int vv, int uu) {
      return map[pattern * cells + static_cast<std::size_t>(vv) * face_.nu +
                 static_cast<std::size_t>(uu)];
    };
    const double a = at_u - u0;
    const double b = at_v - v0;
    return (1 - b) * ((1 - a) * value(v0, u0) + a * value(v0, u1)) +
           b * ((1 - a) * value(v1, u0) + a * value(v1, u1));
  }

  LayeredMedium medium(const Eigen::VectorXd& p) const { return with_unknowns(start_, p); }
  CoefficientPair fields(const LayeredMedium& of) const {
    return to_fields(of, objective_.space());
  }

  /// log prediction − log datum of the data used.
  Eigen::VectorXd residual(const Eigen::VectorXd& p) override {
    if (!std::isfinite(objective_.value(fields(medium(p))))) return {};
    last_ = {p, objective_.prediction()};
    const Problem& problem = objective_.problem();
    for (std::size_t i = 0; i < last_.log_map.size(); ++i) {
      const double floor =
          defaults::expected::darkest_ratio * std::max(std::abs(problem.data[i]), 1e-30);
      last_.log_map[i] = std::log(std::max(last_.log_map[i], floor));
    }
    return residual(last_.log_map, p);
  }
  Eigen::VectorXd residual(const std::vector<double>& log_map, const Eigen::VectorXd& p) const {
    Eigen::VectorXd r(static_cast<Eigen::Index>(used_.size()));
    for (std::size_t k = 0; k < used_.size(); ++k) {
      r[static_cast<Eigen::Index>(k)] =
          shifted(log_map, used_[k], p[2 * layers_ + 1], p[2 * layers_ + 2]) + p[2 * layers_] -
          log_data_[k];
    }
    return r;
  }
  Eigen::VectorXd cheap_residual(const Eigen::VectorXd& p) override {
    return residual(here_.log_map, p);
  }

  /// Updates the heterogeneity from the residuals; weights with it.
  Eigen::VectorXd weights(const Eigen::VectorXd& residual) override {
    double square = 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < used_.size(); ++k) {
      // Without the heterogeneity the brightest data would dominate.
      const double w = 1.0 / (noise_[k] + heterogeneity_ * heterogeneity_);
      square +=
          w * (residual[static_cast<Eigen::Index>(k)] * residual[static_cast<Eigen::Index>(k)] -
               noise_[k]);
      sum += w;
    }
    heterogeneity_ = std::clamp(std::sqrt(std::max(0.0, square / sum)), least_heterogeneity, 1.0);
    weight_.resize(static_cast<Eigen::Index>(used_.size()));
    for (std::size_t k = 0; k < used_.size(); ++k) {
      weight_[static_cast<Eigen::Index>(k)] = 1.0 / (noise_[k] + heterogeneity_ * heterogeneity_);
    }
    return weight_;
  }

  Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) override {
    // Back to p, which is not always where the objective was last.
    objective_.value(fields(medium(p)));
    const Problem& problem = objective_.problem();
    const std::vector<double> prediction = objective_.prediction();
    Eigen::MatrixXd result(static_cast<Eigen::Index>(used_.size()), p.size());
    for (Eigen::Index k = 0; k < 2 * layers_; ++k) {
      std::vector<double> change =
          objective_.jacobian(fields(medium(Eigen::VectorXd::Unit(p.size(), k))));
      for (std::size_t i = 0; i < change.size(); ++i) {
        const double scale = std::sqrt(problem.weight[i]) * prediction[i];
        change[i] = scale > 0.0 ? change[i] / scale : 0.0;
      }
      for (std::size_t i = 0; i < used_.size(); ++i) {
        result(static_cast<Eigen::Index>(i), k) =
            shifted(change, used_[i], p[2 * layers_ + 1], p[2 * layers_ + 2]);
      }
    }
    return result;
  }

  /// Scale and shift cost no solves.
  void set_cheap_columns(const Eigen::VectorXd& p, Eigen::MatrixXd& jacobian) override {
    if (last_.p == p) here_ = last_;
    const double du = p[2 * layers_ + 1];
    const double dv = p[2 * layers_ + 2];
    constexpr double half = 0.5;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto at = [&](double u, double v) { return shifted(here_.log_map, used_[i], u, v); };
      jacobian(row, 2 * layers_) = 1.0;
      jacobian(row, 2 * layers_ + 1) = at(du + half, dv) - at(du - half, dv);
      jacobian(row, 2 * layers_ + 2) = at(du, dv + half) - at(du, dv - half);
    }
  }

  /// Covariance of the parameters from the scatter of the gradient between patterns.
  Eigen::MatrixXd sandwich() const {
    const int patterns = objective_.problem().patterns;
    Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(at_.p.size(), patterns);
    for (std::size_t k = 0; k < used_.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      pull.col(static_cast<Eigen::Index>(used_[k] / face_.cells())) +=
          weight_[row] * at_.residual[row] * at_.jacobian.row(row).transpose();
    }
    const double small_sample = patterns / (patterns - 1.0);
    const Eigen::MatrixXd moved =
        solve_symmetric(normal_matrix(at_.jacobian, weight_, prior_), pull);
    return small_sample * moved * moved.transpose();
  }

  void conclude(const ModelError& model_error, ExposureFit& fit) const {
    const Problem& problem = objective_.problem();
    const Eigen::MatrixXd covariance = sandwich();
    const auto estimate = [&](Eigen::Index k) {
      return Estimate{at_.p[k], std::sqrt(covariance(k, k))};
    };
    fit.medium = medium(at_.p);
    fit.log_scale = estimate(2 * layers_);
    fit.shift_u = estimate(2 * layers_ + 1);
    fit.shift_v = estimate(2 * layers_ + 2);
    fit.heterogeneity = heterogeneity_;
    std::vector<double> prediction(problem.data.size());
    for (std::size_t i = 0; i < prediction.size(); ++i) {
      prediction[i] = std::exp(at_.p[2 * layers_] +
                               shifted(here_.log_map, i, fit.shift_u.value, fit.shift_v.value));
    }
    const Evidence evidence = weigh(problem, prediction, model_error);
    fit.chi2_per_value = evidence.chi2_per_value;
    fit.coherent = evidence.coherent();
    fit.explains = not_rejected(evidence, tolerated_misfit);
  }

  Objective& objective_;
  FaceShape face_;
  LayeredMedium start_;
  Eigen::Index layers_;
  LinearPrior prior_;
  LeastSquaresState at_;  ///< p: log κ and log μ of the layers, log scale, shift in u and v
  std::vector<std::size_t> used_;
  std::vector<double> log_data_;
  std::vector<double> noise_;  ///< variance of log data
  /// log prediction [M][v][u] at p.
  struct LogMap {
    Eigen::VectorXd p;
    std::vector<double> log_map;
  };
  LogMap last_;  ///< evaluated
  LogMap here_;  ///< at at_.p
  double heterogeneity_ = usual_heterogeneity;
  Eigen::VectorXd weight_;
};

}  // namespace

ExposureFit fit_exposure(Objective& objective, const Refinement& finer, const LayeredMedium& start,
                         const ModelError& model_error) {
  check(objective.problem().patterns >= 2, "errors between patterns need two of them");
  Exposure exposure(objective, start);
  objective.refresh_correction(finer, exposure.fields());
  const ExposureFit fit = exposure.run(model_error);
  if (fit.chi2_per_value > far_from_data) return fit;
  objective.refresh_correction(finer, exposure.fields());
  return exposure.run(model_error);
}

}  // namespace kappamu::inverse
