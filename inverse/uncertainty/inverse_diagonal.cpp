#include "inverse/uncertainty/inverse_diagonal.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// A residual this small against the vector it came from is rounding: the space is exhausted.
constexpr double exhausted = 1e-12;

/// Gaussian mean along one axis, normalised to what lies inside the block.
void smooth(std::vector<double>& values, const GridShape& shape, int axis,
            const std::vector<double>& kernel) {
  const int reach = static_cast<int>(kernel.size()) - 1;
  const int n = shape.extent(axis);
  const std::size_t step = axis == 0   ? 1
                           : axis == 1 ? static_cast<std::size_t>(shape.nx)
                                       : static_cast<std::size_t>(shape.nx) * shape.ny;
  const std::vector<double> before = values;
  for_rows(shape.ny * shape.nz, [&](int row) {
    const int y = row % shape.ny;
    const int z = row / shape.ny;
    for (int x = 0; x < shape.nx; ++x) {
      const std::size_t i = shape.index(x, y, z);
      const int at = axis == 0 ? x : axis == 1 ? y : z;
      double sum = 0.0;
      double norm = 0.0;
      for (int k = std::max(-reach, -at); k <= std::min(reach, n - 1 - at); ++k) {
        const double weight = kernel[static_cast<std::size_t>(std::abs(k))];
        const auto offset = static_cast<std::ptrdiff_t>(k) * static_cast<std::ptrdiff_t>(step);
        sum += weight * before[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + offset)];
        norm += weight;
      }
      values[i] = sum / norm;
    }
  });
}

std::vector<double> gaussian(double deviation) {
  std::vector<double> kernel{1.0};
  const int reach = static_cast<int>(std::ceil(2.5 * deviation));
  for (int k = 1; k <= reach; ++k) kernel.push_back(std::exp(-0.5 * std::pow(k / deviation, 2)));
  return kernel;
}

FieldCovariance zeros(std::size_t cells) {
  return {{Vector(cells, 0.0), Vector(cells, 0.0)}, Vector(cells, 0.0)};
}

/// Adds the squares and the product of `x`, each voxel in units of the metric's deviations.
void add_squares(FieldCovariance& sums, const CoefficientPair& x, const FieldCovariance& metric) {
  for (std::size_t i = 0; i < sums.between.size(); ++i) {
    const double kappa = x.log_kappa[i] / std::sqrt(metric.variance.log_kappa[i]);
    const double mu = x.log_mu[i] / std::sqrt(metric.variance.log_mu[i]);
    sums.variance.log_kappa[i] += kappa * kappa;
    sums.variance.log_mu[i] += mu * mu;
    sums.between[i] += kappa * mu;
  }
}

/// rest −= Q Qᵀ rest, the columns of `space` being Q's. Equal bits on any number of cores.
void remove_projection(const Eigen::Ref<const Eigen::MatrixXf>& space, Eigen::VectorXd& rest) {
  const auto size = static_cast<std::size_t>(rest.size());
  const auto part = [](std::size_t begin, std::size_t end) {
    return Eigen::seqN(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
  };
  Eigen::MatrixXd sums(space.cols(), static_cast<Eigen::Index>(pieces(size)));
  for_pieces(size, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    for (Eigen::Index k = 0; k < space.cols(); ++k) {
      sums(k, static_cast<Eigen::Index>(piece)) =
          space.col(k)(part(begin, end)).cast<double>().dot(rest(part(begin, end)));
    }
  });
  const Eigen::VectorXd along = sums.rowwise().sum();
  for_pieces(size, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (Eigen::Index k = 0; k < space.cols(); ++k) {
      rest(part(begin, end)) -= along[k] * space.col(k)(part(begin, end)).cast<double>();
    }
  });
}

}  // namespace

InverseDiagonal::InverseDiagonal(FieldOperator hessian, const GridShape& shape, int depth_axis,
                                 const Basis& basis, int steps)
    : hessian_(std::move(hessian)),
      shape_(shape),
      depth_axis_(depth_axis),
      basis_(basis),
      steps_(steps),
      metric_(basis.covariance()),
      samples_(zeros(shape.cells())),
      controls_(zeros(shape.cells())) {
  check(steps >= 1, "a sample needs at least one product with the Hessian");
}

CoefficientPair InverseDiagonal::sample(const Vector& u) {
  const auto n = static_cast<Eigen::Index>(u.size());
  const Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(u.data(), n);
  const auto most = std::min<Eigen::Index>(steps_, n);
  // Floats hold the vectors: what is lost is far below what a few samples can tell.
  Eigen::MatrixXf space(n, most);
  Eigen::VectorXd diagonal(most);
  Eigen::VectorXd beside(most);
  Eigen::VectorXd next = start / start.norm();
  Eigen::Index size = 0;
  while (true) {
    space.col(size) = next.cast<float>();
    const Vector z(next.data(), next.data() + n);
    const Vector image = basis_.gradient(hessian_(basis_.to_fields(z)));
    Eigen::VectorXd rest = Eigen::Map<const Eigen::VectorXd>(image.data(), n);
    diagonal[size] = next.dot(rest);
    const double scale = rest.norm();
    ++size;
    // Against all earlier ones, twice: rounding would bring the first ones back.
    for (int pass = 0; pass < 2; ++pass) remove_projection(space.leftCols(size), rest);
    beside[size - 1] = rest.norm();
    if (size == most || beside[size - 1] < exhausted * scale) break;
    next = rest / beside[size - 1];
  }
  const SymmetricEigen eigen =
      tridiagonal_eigen(diagonal.head(size), beside.head(std::max<Eigen::Index>(size - 1, 0)));
  check(eigen.values[0] > 0.0, "the Hessian of a fit must be positive definite");
  const Eigen::VectorXd coefficients =
      eigen.vectors * eigen.values.cwiseSqrt().cwiseInverse().cwiseProduct(
                          eigen.vectors.row(0).transpose() * start.norm());
  unfinished_ = std::max(unfinished_, std::abs(coefficients[size - 1]) / coefficients.norm());
  Vector root(u.size(), 0.0);
  for_pieces(root.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (Eigen::Index k = 0; k < size; ++k) {
      const float* const column = space.col(k).data();
      for (std::size_t i = begin; i < end; ++i) {
        root[i] += coefficients[k] * static_cast<double>(column[i]);
      }
    }
  });
  return basis_.to_fields(root);
}

void InverseDiagonal::add(const Vector& u) {
  add_squares(samples_, sample(u), metric_);
  add_squares(controls_, basis_.to_fields(u), metric_);
  ++count_;
}

FieldCovariance InverseDiagonal::result(double pooling) const {
  if (count_ == 0) return metric_;
  FieldCovariance x = samples_;
  FieldCovariance y = controls_;
  if (pooling > 0.0) {
    const std::vector<double> kernel = gaussian(pooling);
    for (FieldCovariance* sums : {&x, &y}) {
      for (Vector* values : {&sums->variance.log_kappa, &sums->variance.log_mu, &sums->between}) {
        for (int axis = 0; axis < 3; ++axis) {
          if (axis != depth_axis_) smooth(*values, shape_, axis, kernel);
        }
      }
    }
  }
  FieldCovariance found = metric_;
  for (std::size_t i = 0; i < shape_.cells(); ++i) {
    const double kappa_unit = metric_.variance.log_kappa[i];
    const double mu_unit = metric_.variance.log_mu[i];
    found.variance.log_kappa[i] = kappa_unit * x.variance.log_kappa[i] / y.variance.log_kappa[i];
    found.variance.log_mu[i] = mu_unit * x.variance.log_mu[i] / y.variance.log_mu[i];
    found.between[i] += std::sqrt(kappa_unit * mu_unit) * (x.between[i] - y.between[i]) / count_;
    const double most = std::sqrt(found.variance.log_kappa[i] * found.variance.log_mu[i]);
    found.between[i] = std::clamp(found.between[i], -most, most);
  }
  return found;
}

}  // namespace kappamu::inverse
