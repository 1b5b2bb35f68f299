#include "core/numbers/cosine_transform.h"

#include <cmath>
#include <numbers>

#include "core/numbers/dense_product.h"

namespace kappamu {

namespace {

/// Below, folding costs more than it saves.
constexpr int shortest_folded = 16;

double cosine(int n, int k, int i) {
  return std::sqrt((k == 0 ? 1.0 : 2.0) / n) * std::cos(std::numbers::pi * k * (i + 0.5) / n);
}

const auto even = Eigen::seq(0, Eigen::last, Eigen::fix<2>);
const auto odd = Eigen::seq(1, Eigen::last, Eigen::fix<2>);

}  // namespace

CosineTransform::CosineTransform(int n) : n_(n) {
  const bool folded = n % 2 == 0 && n >= shortest_folded;
  if (folded) half_ = std::make_shared<CosineTransform>(n / 2);
  const int size = folded ? n / 2 : n;
  matrix_.resize(size, size);
  for (int k = 0; k < size; ++k) {
    for (int i = 0; i < size; ++i) matrix_(k, i) = cosine(n, folded ? 2 * k + 1 : k, i);
  }
  transposed_ = matrix_.transpose();
}

Eigen::MatrixXd CosineTransform::forward(const Eigen::MatrixXd& values) const {
  if (!half_) return product(matrix_, values);
  const Eigen::MatrixXd mirrored = values.bottomRows(n_ / 2).colwise().reverse();
  Eigen::MatrixXd out(n_, values.cols());
  // C_n(2k, i) = C_{n/2}(k, i)/√2.
  out(even, Eigen::all) =
      std::numbers::sqrt2 / 2.0 * half_->forward(values.topRows(n_ / 2) + mirrored);
  out(odd, Eigen::all) = product(matrix_, values.topRows(n_ / 2) - mirrored);
  return out;
}

Eigen::MatrixXd CosineTransform::inverse(const Eigen::MatrixXd& frequencies) const {
  if (!half_) return product(transposed_, frequencies);
  const Eigen::MatrixXd sums =
      std::numbers::sqrt2 / 2.0 * half_->inverse(frequencies(even, Eigen::all));
  const Eigen::MatrixXd differences = product(transposed_, frequencies(odd, Eigen::all));
  Eigen::MatrixXd out(n_, frequencies.cols());
  out.topRows(n_ / 2) = sums + differences;
  out.bottomRows(n_ / 2) = (sums - differences).colwise().reverse();
  return out;
}

}  // namespace kappamu
