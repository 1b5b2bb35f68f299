#include "core/numbers/cosine_transform.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "core/numbers/widest.h"

namespace kappamu {

namespace {

/// Longer even lengths are halved.
constexpr int longest_dense = 4;
/// Of the product with a dense matrix, held in registers.
constexpr int tile_rows = 8;
/// Rows side by side in a vector register. GCC moves wider vectors through the stack where the
/// processor has none so wide.
constexpr Eigen::Index lanes = 4;
// NOLINTNEXTLINE: of doubles in any place, unlike a vector by itself
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double)), aligned(8), may_alias));

constexpr double root_half = std::numbers::sqrt2 / 2.0;

}  // namespace

struct CosineTransform::Length {
  int n = 1;
  std::vector<double> two, two_inverse, four;  ///< dense matrices [out][in], where not halved
  std::vector<double> cosine, sine;            ///< of π (2 i + 1)/(4 n), where halved
  std::unique_ptr<const Length> half;
};

namespace {

using Length = CosineTransform::Length;

std::unique_ptr<Length> make_length(int n) {
  auto length = std::make_unique<Length>();
  length->n = n;
  if (n % 2 == 0 && n > longest_dense) {
    for (int i = 0; i < n / 2; ++i) {
      length->cosine.push_back(std::cos(std::numbers::pi * (2 * i + 1) / (4.0 * n)));
      length->sine.push_back(std::sin(std::numbers::pi * (2 * i + 1) / (4.0 * n)));
    }
    length->half = make_length(n / 2);
    return length;
  }
  const auto two = [n](int k, int i) {
    return std::sqrt((k == 0 ? 1.0 : 2.0) / n) * std::cos(std::numbers::pi * k * (i + 0.5) / n);
  };
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < n; ++i) {
      length->two.push_back(two(k, i));
      length->two_inverse.push_back(two(i, k));
      length->four.push_back(std::sqrt(2.0 / n) *
                             std::cos(std::numbers::pi * (k + 0.5) * (i + 0.5) / n));
    }
  }
  for (std::vector<double>* matrix : {&length->two, &length->two_inverse, &length->four}) {
    matrix->resize(static_cast<std::size_t>((n + tile_rows - 1) / tile_rows * tile_rows * n), 0.0);
  }
  return length;
}

/// x becomes matrix · x, [out][in] with rows of zeros up to a multiple of tile_rows; y is scratch,
/// as below.
KAPPAMU_WIDEST void multiply(const std::vector<double>& matrix, int n, Lanes* x, Lanes* y) {
  for (int k = 0; k < n; k += tile_rows) {
    const double* rows = matrix.data() + static_cast<std::ptrdiff_t>(k) * n;
    Lanes sum[tile_rows] = {};
    for (int i = 0; i < n; ++i) {
      for (int t = 0; t < tile_rows; ++t) sum[t] += rows[t * n + i] * x[i];
    }
    for (int t = 0; t < std::min(tile_rows, n - k); ++t) y[k + t] = sum[t];
  }
  std::copy_n(y, n, x);
}

KAPPAMU_WIDEST void transform_two(const Length& length, Lanes* x, Lanes* y);

/// DCT-IV, its own inverse: √(2/n) cos(π (k + ½)(i + ½)/n).
KAPPAMU_WIDEST void transform_four(const Length& length, Lanes* x, Lanes* y) {
  const int n = length.n, m = n / 2;
  if (!length.half) return multiply(length.four, n, x, y);
  for (int i = 0; i < m; ++i) {
    const double c = length.cosine[static_cast<std::size_t>(i)];
    const double s = length.sine[static_cast<std::size_t>(i)];
    const double odd = i % 2 == 0 ? 1.0 : -1.0;
    y[i] = c * x[i] + s * x[n - 1 - i];
    y[m + i] = odd * c * x[n - 1 - i] - odd * s * x[i];
  }
  transform_two(*length.half, y, x);
  transform_two(*length.half, y + m, x + m);
  x[0] = y[0];
  for (int j = 1; j < m; ++j) {
    x[2 * j - 1] = root_half * (y[j] - y[n - j]);
    x[2 * j] = root_half * (y[j] + y[n - j]);
  }
  x[n - 1] = -y[m];
}

/// Even frequencies are the DCT-II of sums of mirrored values, odd ones the DCT-IV of differences.
KAPPAMU_WIDEST void transform_two(const Length& length, Lanes* x, Lanes* y) {
  const int n = length.n, m = n / 2;
  if (!length.half) return multiply(length.two, n, x, y);
  for (int i = 0; i < m; ++i) {
    y[i] = root_half * (x[i] + x[n - 1 - i]);
    y[m + i] = root_half * (x[i] - x[n - 1 - i]);
  }
  transform_two(*length.half, y, x);
  transform_four(*length.half, y + m, x + m);
  for (int k = 0; k < m; ++k) {
    x[2 * k] = y[k];
    x[2 * k + 1] = y[m + k];
  }
}

KAPPAMU_WIDEST void invert_two(const Length& length, Lanes* x, Lanes* y) {
  const int n = length.n, m = n / 2;
  if (!length.half) return multiply(length.two_inverse, n, x, y);
  for (int k = 0; k < m; ++k) {
    y[k] = x[2 * k];
    y[m + k] = x[2 * k + 1];
  }
  invert_two(*length.half, y, x);
  transform_four(*length.half, y + m, x + m);
  for (int i = 0; i < m; ++i) {
    x[i] = root_half * (y[i] + y[m + i]);
    x[n - 1 - i] = root_half * (y[i] - y[m + i]);
  }
}

using Transform = void (*)(const Length&, Lanes*, Lanes*);

Eigen::MatrixXd of_rows(const Length& length, Transform transform, const Eigen::MatrixXd& values) {
  Eigen::MatrixXd out(values.rows(), values.cols());
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(lanes, length.n), y = x;
  for (Eigen::Index row = 0; row < values.rows(); row += lanes) {
    const Eigen::Index count = std::min(lanes, values.rows() - row);
    x.topRows(count) = values.middleRows(row, count);
    transform(length, reinterpret_cast<Lanes*>(x.data()), reinterpret_cast<Lanes*>(y.data()));
    out.middleRows(row, count) = x.topRows(count);
  }
  return out;
}

}  // namespace

CosineTransform::CosineTransform(int n) : length_(make_length(n)) {}

Eigen::MatrixXd CosineTransform::forward_rows(const Eigen::MatrixXd& values) const {
  return of_rows(*length_, transform_two, values);
}
Eigen::MatrixXd CosineTransform::inverse_rows(const Eigen::MatrixXd& frequencies) const {
  return of_rows(*length_, invert_two, frequencies);
}
Eigen::MatrixXd CosineTransform::forward(const Eigen::MatrixXd& values) const {
  return forward_rows(values.transpose()).transpose();
}
Eigen::MatrixXd CosineTransform::inverse(const Eigen::MatrixXd& frequencies) const {
  return inverse_rows(frequencies.transpose()).transpose();
}

Eigen::MatrixXd to_waves(const CosineTransform& a, const CosineTransform& b,
                         const Eigen::MatrixXd& image) {
  const Eigen::MatrixXd turned = b.forward_rows(image).transpose();
  return a.forward_rows(turned).transpose();
}
Eigen::MatrixXd from_waves(const CosineTransform& a, const CosineTransform& b,
                           const Eigen::MatrixXd& frequencies) {
  const Eigen::MatrixXd turned = b.inverse_rows(frequencies).transpose();
  return a.inverse_rows(turned).transpose();
}

}  // namespace kappamu
