#include "inverse/block_model/systematic_error.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/numbers/dot.h"
#include "core/numbers/linear_algebra.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::systematic_error;

struct Lag {
  double squared_distance = 0.0;
  double product = 0.0;  ///< mean
  double pairs = 0.0;
};

std::vector<double> weighted_residual(const Problem& problem,
                                      const std::vector<double>& prediction) {
  std::vector<double> residual(prediction.size());
  for (std::size_t i = 0; i < residual.size(); ++i) {
    residual[i] = std::sqrt(problem.weight[i]) * (prediction[i] - problem.data[i]);
  }
  return residual;
}

/// Mean products of residuals of one pattern over all lags of half the plane.
std::vector<Lag> products_by_lag(const Problem& problem, const std::vector<double>& residual) {
  const FaceShape face = problem.seen_shape();
  std::vector<Lag> lags;
  for (int dv = 0; dv <= std::min(longest_lag, face.nv / 2); ++dv) {
    const int most = std::min(longest_lag, face.nu / 2);
    for (int du = dv == 0 ? 1 : -most; du <= most; ++du) {
      Lag lag{static_cast<double>(du * du + dv * dv)};
      for (int m = 0; m < problem.patterns; ++m) {
        for (int v = 0; v + dv < face.nv; ++v) {
          const std::size_t row = (static_cast<std::size_t>(m) * face.nv + v) * face.nu;
          const std::size_t other = row + static_cast<std::size_t>(dv) * face.nu;
          for (int u = std::max(0, -du); u < face.nu && u + du < face.nu; ++u) {
            const std::size_t i = row + static_cast<std::size_t>(u);
            const std::size_t j = other + static_cast<std::size_t>(u + du);
            if (problem.weight[i] <= 0.0 || problem.weight[j] <= 0.0) continue;
            lag.product += residual[i] * residual[j];
            lag.pairs += 1.0;
          }
        }
      }
      if (lag.pairs == 0.0) continue;
      lag.product /= lag.pairs;
      lags.push_back(lag);
    }
  }
  return lags;
}

/// Row i is what pixel i takes of independent numbers, such that the products of two pixels have
/// the correlation exp(−d²/2 length²) and each the variance 1, at borders too.
Eigen::MatrixXd correlating(int pixels, double length) {
  Eigen::MatrixXd rows(pixels, pixels);
  for (int i = 0; i < pixels; ++i) {
    for (int k = 0; k < pixels; ++k) rows(i, k) = std::exp(-std::pow((i - k) / length, 2));
    rows.row(i).normalize();
  }
  return rows;
}

}  // namespace

bool SystematicError::found(double tolerated) const {
  return variance > tolerated + sure_deviations * variance_error;
}

SystematicError estimate_systematic_error(const Problem& problem,
                                          const CorrectedPrediction& prediction) {
  std::vector<double> residual = weighted_residual(problem, prediction.value);
  SystematicError error;
  const auto used = static_cast<double>(problem.used());
  if (used == 0.0) return error;
  if (prediction.ratio_is_of_grid) {
    std::vector<double> of_grid(residual.size());
    for (std::size_t i = 0; i < of_grid.size(); ++i) {
      of_grid[i] =
          std::sqrt(problem.weight[i]) * prediction.value[i] * (1.0 - 1.0 / prediction.ratio[i]);
    }
    // The finer grid's error is a third of the difference at second order, all of it at first.
    const double share = dot(residual, of_grid) / (dot(of_grid, of_grid) + 1.0);
    for (std::size_t i = 0; i < residual.size(); ++i) {
      residual[i] -= std::clamp(share, -1.0, 1.0) * of_grid[i];
    }
  }
  const double total = dot(residual, residual) / used;
  const std::vector<Lag> lags = products_by_lag(problem, residual);
  double best = 0.0;
  double power = 0.0;
  for (double length = shortest_length; length <= longest_length; length *= length_factor) {
    double product = 0.0;
    double square = 0.0;
    for (const Lag& lag : lags) {
      const double shape = std::exp(-0.5 * lag.squared_distance / (length * length));
      product += lag.pairs * shape * lag.product;
      square += lag.pairs * shape * shape;
    }
    if (square <= 0.0 || product <= 0.0) continue;
    const double explained = product * product / square;
    if (explained <= best) continue;
    best = explained;
    power = square;
    error.variance = std::min(product / square, total);
    error.length = length;
  }
  error.white = std::max(1.0, total - error.variance);
  error.variance_error = power > 0.0 ? std::max(1.0, total) / std::sqrt(power) : 1.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    squares += problem.weight[i] * prediction.value[i] * prediction.value[i];
  }
  error.relative = std::sqrt(error.variance * used / squares);
  error.excess = std::sqrt(std::max(total - 1.0, error.variance) * used / squares);
  return error;
}

ErrorCovariance::ErrorCovariance(const Problem& problem, const std::vector<double>& prediction,
                                 const SystematicError& error, double common)
    : problem_(problem),
      error_(error),
      along_u_(correlating(problem.seen_shape().nu, error.length)),
      along_v_(correlating(problem.seen_shape().nv, error.length)) {
  if (common <= 0.0) return;
  const FaceShape face = problem.seen_shape();
  const double largest = *std::max_element(prediction.begin(), prediction.end());
  std::vector<std::vector<double>> columns(4, std::vector<double>(prediction.size()));
  std::size_t i = 0;
  for (int line = 0; line < problem.patterns * face.nv; ++line) {
    const int v = line % face.nv;
    for (int u = 0; u < face.nu; ++u, ++i) {
      const double root = std::sqrt(problem.weight[i]);
      const double value = prediction[i];
      const auto slope = [&](int at, int count, std::size_t stride) {
        const std::size_t after = at + 1 < count ? i + stride : i;
        const std::size_t before = at > 0 ? i - stride : i;
        return after == before
                   ? 0.0
                   : (prediction[after] - prediction[before]) * static_cast<double>(stride) /
                         static_cast<double>(after - before);
      };
      columns[0][i] = root * value;
      columns[1][i] = value > 0.0 ? root * value * std::log(value / largest) : 0.0;
      columns[2][i] = root * slope(u, face.nu, 1);
      columns[3][i] = root * slope(v, face.nv, static_cast<std::size_t>(face.nu));
    }
  }
  const double size = common * common * dot(columns[0], columns[0]);
  for (std::vector<double>& column : columns) {
    const double square = dot(column, column);
    if (square <= 0.0) continue;
    for (double& x : column) x *= std::sqrt(size / square);
    common_.push_back(std::move(column));
  }
}

Eigen::MatrixXd ErrorCovariance::between(const Eigen::MatrixXd& jacobian,
                                         const std::vector<std::size_t>& rows) const {
  const FaceShape face = problem_.seen_shape();
  Eigen::MatrixXd sum = error_.white * jacobian.transpose() * jacobian;
  for (const std::vector<double>& column : common_) {
    Eigen::VectorXd product = Eigen::VectorXd::Zero(jacobian.cols());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      product += column[rows[k]] * jacobian.row(static_cast<Eigen::Index>(k)).transpose();
    }
    sum += product * product.transpose();
  }
  if (error_.variance <= 0.0) return sum;
  // Jᵀ R J by pattern: R = B Bᵀ, B the two correlating matrices.
  const auto cells = static_cast<Eigen::Index>(face.cells());
  std::size_t k = 0;
  for (int m = 0; m < problem_.patterns; ++m) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(cells, jacobian.cols());
    const std::size_t end = (static_cast<std::size_t>(m) + 1) * face.cells();
    for (; k < rows.size() && rows[k] < end; ++k) {
      full.row(static_cast<Eigen::Index>(rows[k] % face.cells())) =
          jacobian.row(static_cast<Eigen::Index>(k));
    }
    for (Eigen::Index c = 0; c < full.cols(); ++c) {
      Eigen::Map<Eigen::MatrixXd> map(full.col(c).data(), face.nu, face.nv);
      map = (along_u_.transpose() * map * along_v_).eval();
    }
    sum += error_.variance * full.transpose() * full;
  }
  return sum;
}

Eigen::VectorXd ErrorCovariance::without_common(const Eigen::VectorXd& residual,
                                                const Eigen::MatrixXd& jacobian,
                                                const std::vector<std::size_t>& rows) const {
  const auto columns = static_cast<Eigen::Index>(common_.size());
  Eigen::MatrixXd all(jacobian.rows(), jacobian.cols() + columns);
  all.leftCols(jacobian.cols()) = jacobian;
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      all(static_cast<Eigen::Index>(k), jacobian.cols() + c) =
          common_[static_cast<std::size_t>(c)][rows[k]];
    }
  }
  Eigen::MatrixXd normal = all.transpose() * all;
  normal.diagonal().array() += 1.0;  // what the columns' sizes make their prior
  return residual - all * solve_symmetric(normal, all.transpose() * residual);
}

std::vector<double> ErrorCovariance::draw(std::mt19937_64& engine) const {
  std::normal_distribution<double> normal;
  const FaceShape face = problem_.seen_shape();
  std::vector<double> residual(problem_.data.size());
  std::vector<double> sizes;
  for (std::size_t k = 0; k < common_.size(); ++k) sizes.push_back(normal(engine));
  std::size_t i = 0;
  for (int m = 0; m < problem_.patterns; ++m) {
    Eigen::MatrixXd map(face.nu, face.nv);
    for (double& x : map.reshaped()) x = normal(engine);
    map = (along_u_ * map * along_v_.transpose()).eval();
    for (const double smooth : map.reshaped()) {
      const double white = normal(engine);
      if (problem_.weight[i] > 0.0) {
        residual[i] = std::sqrt(error_.white) * white + std::sqrt(error_.variance) * smooth;
        for (std::size_t k = 0; k < common_.size(); ++k) residual[i] += sizes[k] * common_[k][i];
      }
      ++i;
    }
  }
  return residual;
}

double structure_ratio(Objective& objective, const std::vector<double>& residual,
                       const ErrorCovariance& errors, int draws, std::uint64_t seed) {
  const GridShape& shape = objective.space().shape;
  const int axis = objective.space().depth_axis;
  const auto slices = static_cast<std::size_t>(shape.extent(axis));
  // Squares of the gradient by coefficient and slice, less its mean, which layers can follow:
  // voxels differ in sensitivity mostly by depth.
  const auto squares_of = [&](const std::vector<double>& s) {
    const CoefficientPair gradient = objective.jacobian_transpose(s);
    std::vector<double> sums(2 * slices, 0.0);
    std::vector<double> squares(2 * slices, 0.0);
    std::size_t i = 0;
    for (int z = 0; z < shape.nz; ++z) {
      for (int y = 0; y < shape.ny; ++y) {
        for (int x = 0; x < shape.nx; ++x, ++i) {
          const auto slice = static_cast<std::size_t>(axis == 0 ? x : axis == 1 ? y : z);
          const std::array<double, 2> g{gradient.log_kappa[i], gradient.log_mu[i]};
          for (std::size_t q = 0; q < 2; ++q) {
            sums[q * slices + slice] += g[q];
            squares[q * slices + slice] += g[q] * g[q];
          }
        }
      }
    }
    const auto cells = static_cast<double>(shape.cells() / slices);
    for (std::size_t k = 0; k < sums.size(); ++k) squares[k] -= sums[k] * sums[k] / cells;
    return squares;
  };
  const std::vector<double> found = squares_of(residual);
  std::vector<double> expected(found.size(), 0.0);
  std::mt19937_64 engine(seed);
  for (int k = 0; k < draws; ++k) {
    const std::vector<double> by_chance = squares_of(errors.draw(engine));
    for (std::size_t s = 0; s < expected.size(); ++s) expected[s] += by_chance[s] / draws;
  }
  double ratio = 0.0;
  for (std::size_t s = 0; s < found.size(); ++s) {
    ratio += found[s] / expected[s] / static_cast<double>(found.size());
  }
  return ratio;
}

ChanceRise chance_rise(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& between,
                       const Eigen::MatrixXd& copies) {
  const Eigen::MatrixXd fewer = (copies.transpose() * normal * copies).eval();
  const Eigen::MatrixXd kept = copies * solve_symmetric(fewer, copies.transpose());
  const Eigen::MatrixXd all =
      solve_symmetric(normal, Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
  const Eigen::MatrixXd product = (all - kept) * between;
  return {product.trace(), std::sqrt(std::max(0.0, 2.0 * (product * product).trace()))};
}

}  // namespace kappamu::inverse
