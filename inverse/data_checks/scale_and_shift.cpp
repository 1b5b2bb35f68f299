#include "inverse/data_checks/scale_and_shift.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "inverse/block_model/model_evidence.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/problem/expected_blocks.h"

namespace kappamu::inverse {

namespace {

constexpr int max_steps = 20;
constexpr double step_tolerance = 2e-3;
/// χ² per value from which a second correction of the grid changes nothing that matters.
constexpr double far_from_data = 4.0;
constexpr double tolerated_misfit = 0.05;
/// Where it starts, and what no fit goes below.
constexpr double usual_heterogeneity = 0.3;
constexpr double least_heterogeneity = 1e-3;
/// Spread of log scale and, over the face's extent, of the shift: for light that tells neither.
constexpr double scale_spread = 1.0;
constexpr double free_shift_spread = 0.25;
/// Beyond, the scale or the shift is no slip of a rig but a fit gone astray.
constexpr double largest_log_scale = 2.5;
constexpr double largest_shift = 0.25;  ///< of the face's extent

class Exposure {
 public:
  Exposure(Objective& objective, const LayeredMedium& start)
      : objective_(objective),
        face_(objective.problem().seen_shape()),
        first_(start.first),
        layers_(static_cast<Eigen::Index>(start.first.size())),
        p_(Eigen::VectorXd::Zero(2 * layers_ + 3)) {
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
    p_.head(layers_) = Eigen::Map<const Eigen::VectorXd>(start.log_kappa.data(), layers_);
    p_.segment(layers_, layers_) = Eigen::Map<const Eigen::VectorXd>(start.log_mu.data(), layers_);
    anchor_ = absorption(p_);
  }

  CoefficientPair fields() const { return fields(medium(p_)); }

  /// From where the last call ended, whose derivatives another correction does not change.
  ExposureFit run(const ModelError& model_error) {
    ExposureFit fit;
    if (!evaluate(p_, here_)) throw InputError("the diffusion solver fails at the start");
    double damping = 1e-2;
    bool fresh = false;
    for (int step = 0; step < max_steps && !fit.converged; ++step) {
      weigh_anew(here_.residual);
      if (slopes_.empty()) {
        differentiate();
        fresh = true;
      }
      linearise();
      const Eigen::MatrixXd normal = hessian();
      const Eigen::VectorXd slope = -gradient(here_.residual);
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * normal.diagonal();
      Eigen::VectorXd move = damped.ldlt().solve(slope);
      const double largest = move.cwiseAbs().maxCoeff();
      if (largest > longest_step) move *= longest_step / largest;
      fit.converged = largest < step_tolerance;
      if (fit.converged) break;
      Point next;
      const Eigen::VectorXd to = bounded(p_ + move);
      const double cost = cost_of(p_, here_.residual);
      const double gain = evaluate(to, next) ? cost - cost_of(to, next.residual) : -cost;
      const bool poor = gain < trusted_step * (2.0 * slope.dot(move) - move.dot(normal * move));
      if (gain > 0.0) {
        improve_slopes(to - p_, next);
        p_ = to;
        here_ = std::move(next);
        damping = std::max(1e-6, 0.2 * damping);
      } else {
        damping *= 8.0;
      }
      if (poor && (gain > 0.0 || !fresh)) slopes_.clear();
      fresh = fresh && gain <= 0.0;
    }
    conclude(model_error, fit);
    return fit;
  }

 private:
  struct Point {
    std::vector<double> log_map;  ///< log prediction [M][v][u]
    Eigen::VectorXd residual;     ///< log prediction − log datum of the data used
  };

  double absorption(const Eigen::VectorXd& p) const {
    return p.head(2 * layers_).sum() / static_cast<double>(layers_);
  }
  double& log_scale(Eigen::VectorXd& p) const { return p[2 * layers_]; }

  Eigen::VectorXd bounded(Eigen::VectorXd p) const {
    log_scale(p) = std::clamp(log_scale(p), -largest_log_scale, largest_log_scale);
    const double u = largest_shift * face_.nu;
    const double v = largest_shift * face_.nv;
    p[2 * layers_ + 1] = std::clamp(p[2 * layers_ + 1], -u, u);
    p[2 * layers_ + 2] = std::clamp(p[2 * layers_ + 2], -v, v);
    return p;
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

  LayeredMedium medium(const Eigen::VectorXd& p) const {
    return {first_, std::vector<double>(p.data(), p.data() + layers_),
            std::vector<double>(p.data() + layers_, p.data() + 2 * layers_)};
  }
  CoefficientPair fields(const LayeredMedium& of) const {
    const forward::GridSetup& setup = objective_.problem().setup;
    return to_fields(of, setup.shape, axis_of(setup.lit_face));
  }

  bool evaluate(const Eigen::VectorXd& p, Point& at) {
    if (!std::isfinite(objective_.value(fields(medium(p))))) return false;
    at.log_map = objective_.prediction();
    const Problem& problem = objective_.problem();
    for (std::size_t i = 0; i < at.log_map.size(); ++i) {
      const double floor = darkest_ratio * std::max(std::abs(problem.data[i]), 1e-30);
      at.log_map[i] = std::log(std::max(at.log_map[i], floor));
    }
    at.residual.resize(static_cast<Eigen::Index>(used_.size()));
    for (std::size_t k = 0; k < used_.size(); ++k) {
      at.residual[static_cast<Eigen::Index>(k)] =
          shifted(at.log_map, used_[k], p[2 * layers_ + 1], p[2 * layers_ + 2]) + p[2 * layers_] -
          log_data_[k];
    }
    return true;
  }

  /// Heterogeneity and weights that the residuals suggest.
  void weigh_anew(const Eigen::VectorXd& residual) {
    double square = 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < used_.size(); ++k) {
      // Bright, precise data would otherwise decide alone.
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
  }

  /// slopes_ at p_.
  void differentiate() {
    // Back to p_, which is not always where the objective was last.
    objective_.value(fields());
    const Problem& problem = objective_.problem();
    const std::vector<double> prediction = objective_.prediction();
    for (Eigen::Index k = 0; k < 2 * layers_; ++k) {
      std::vector<double> change =
          objective_.jacobian(fields(medium(Eigen::VectorXd::Unit(p_.size(), k))));
      for (std::size_t i = 0; i < change.size(); ++i) {
        const double scale = std::sqrt(problem.weight[i]) * prediction[i];
        change[i] = scale > 0.0 ? change[i] / scale : 0.0;
      }
      slopes_.push_back(std::move(change));
    }
  }

  /// Broyden's: what the step `move` to `next` left unforeseen.
  void improve_slopes(const Eigen::VectorXd& move, const Point& next) {
    const double square = move.head(2 * layers_).squaredNorm();
    if (square == 0.0) return;
    for (std::size_t i = 0; i < next.log_map.size(); ++i) {
      double surprise = next.log_map[i] - here_.log_map[i];
      for (std::size_t k = 0; k < slopes_.size(); ++k) {
        surprise -= slopes_[k][i] * move[static_cast<Eigen::Index>(k)];
      }
      for (std::size_t k = 0; k < slopes_.size(); ++k) {
        slopes_[k][i] += surprise / square * move[static_cast<Eigen::Index>(k)];
      }
    }
  }

  /// jacobian_ at p_ from slopes_; scale and shift cost no solves.
  void linearise() {
    const double du = p_[2 * layers_ + 1];
    const double dv = p_[2 * layers_ + 2];
    jacobian_.resize(static_cast<Eigen::Index>(used_.size()), p_.size());
    constexpr double half = 0.5;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      for (std::size_t k = 0; k < slopes_.size(); ++k) {
        jacobian_(row, static_cast<Eigen::Index>(k)) = shifted(slopes_[k], used_[i], du, dv);
      }
      const auto at = [&](double u, double v) { return shifted(here_.log_map, used_[i], u, v); };
      jacobian_(row, 2 * layers_) = 1.0;
      jacobian_(row, 2 * layers_ + 1) = at(du + half, dv) - at(du - half, dv);
      jacobian_(row, 2 * layers_ + 2) = at(du, dv + half) - at(du, dv - half);
    }
  }

  /// Rows of the prior times p, less what is expected.
  Eigen::VectorXd prior(const Eigen::VectorXd& p) const {
    Eigen::VectorXd rows(2 * layers_ + 2);
    for (Eigen::Index l = 0; l + 1 < layers_; ++l) {
      rows[2 * l] = (p[l + 1] - p[l]) / layer_spread;
      rows[2 * l + 1] = (p[layers_ + l + 1] - p[layers_ + l]) / layer_spread;
    }
    rows[2 * layers_ - 2] = (absorption(p) - anchor_) / absorption_spread;
    rows[2 * layers_ - 1] = p[2 * layers_] / scale_spread;
    rows[2 * layers_] = p[2 * layers_ + 1] / (free_shift_spread * face_.nu);
    rows[2 * layers_ + 1] = p[2 * layers_ + 2] / (free_shift_spread * face_.nv);
    return rows;
  }
  Eigen::MatrixXd prior_jacobian() const {
    Eigen::MatrixXd rows(2 * layers_ + 2, p_.size());
    const Eigen::VectorXd at_zero = prior(Eigen::VectorXd::Zero(p_.size()));
    for (Eigen::Index k = 0; k < p_.size(); ++k) {
      rows.col(k) = prior(Eigen::VectorXd::Unit(p_.size(), k)) - at_zero;
    }
    return rows;
  }
  double cost_of(const Eigen::VectorXd& p, const Eigen::VectorXd& residual) const {
    return residual.cwiseAbs2().dot(weight_) + prior(p).squaredNorm();
  }
  Eigen::MatrixXd hessian() const {
    const Eigen::MatrixXd of_prior = prior_jacobian();
    return jacobian_.transpose() * weight_.asDiagonal() * jacobian_ +
           of_prior.transpose() * of_prior;
  }
  Eigen::VectorXd gradient(const Eigen::VectorXd& residual) const {
    return jacobian_.transpose() * weight_.cwiseProduct(residual) +
           prior_jacobian().transpose() * prior(p_);
  }

  /// Spread between patterns of what each pulls the parameters to.
  Eigen::MatrixXd sandwich(const Eigen::VectorXd& residual) const {
    const int patterns = objective_.problem().patterns;
    Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(p_.size(), patterns);
    for (std::size_t k = 0; k < used_.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      pull.col(static_cast<Eigen::Index>(used_[k] / face_.cells())) +=
          weight_[row] * residual[row] * jacobian_.row(row).transpose();
    }
    const double small_sample = patterns / (patterns - 1.0);
    const Eigen::LDLT<Eigen::MatrixXd> normal(hessian());
    const Eigen::MatrixXd moved = normal.solve(pull);
    return small_sample * moved * moved.transpose();
  }

  void conclude(const ModelError& model_error, ExposureFit& fit) const {
    const Problem& problem = objective_.problem();
    const Eigen::MatrixXd covariance = sandwich(here_.residual);
    const auto estimate = [&](Eigen::Index k) {
      return Estimate{p_[k], std::sqrt(covariance(k, k))};
    };
    fit.medium = medium(p_);
    fit.log_scale = estimate(2 * layers_);
    fit.shift_u = estimate(2 * layers_ + 1);
    fit.shift_v = estimate(2 * layers_ + 2);
    fit.heterogeneity = heterogeneity_;
    std::vector<double> prediction(problem.data.size());
    for (std::size_t i = 0; i < prediction.size(); ++i) {
      prediction[i] = std::exp(p_[2 * layers_] +
                               shifted(here_.log_map, i, fit.shift_u.value, fit.shift_v.value));
    }
    const Evidence evidence = weigh(problem, prediction, model_error);
    fit.chi2_per_value = evidence.chi2_per_value;
    fit.coherent = evidence.coherent();
    fit.explains = not_rejected(evidence, tolerated_misfit);
  }

  Objective& objective_;
  FaceShape face_;
  std::vector<int> first_;
  Eigen::Index layers_;
  Eigen::VectorXd p_;  ///< log κ and log μ of the layers, log scale, shift in u and v
  double anchor_ = 0.0;
  std::vector<std::size_t> used_;
  std::vector<double> log_data_;
  std::vector<double> noise_;                ///< variance of log data
  Point here_;                               ///< at p_
  std::vector<std::vector<double>> slopes_;  ///< of the log map by log κ and log μ, [2][M][v][u]
  double heterogeneity_ = usual_heterogeneity;
  Eigen::VectorXd weight_;
  Eigen::MatrixXd jacobian_;
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
