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
  if (n == longest_dense) {
    const Lanes a = x[0], b = x[1], c = x[2], d = x[3];
    const double* row = matrix.data();
    for (int k = 0; k < n; ++k, row += n) x[k] = row[0] * a + row[1] * b + row[2] * c + row[3] * d;
    return;
  }
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

void run(const Length& length, Transform transform, double* x, double* scratch) {
  transform(length, reinterpret_cast<Lanes*>(x), reinterpret_cast<Lanes*>(scratch));
}

/// `count` rows of an image [column][row] to the lanes of x, and back.
void take_rows(const double* image, Eigen::Index rows, Eigen::Index count, int n, double* x) {
  for (int i = 0; i < n; ++i, image += rows, x += lanes) {
    count == lanes ? std::copy_n(image, lanes, x) : std::copy_n(image, count, x);
  }
}
void put_rows(const double* x, Eigen::Index rows, Eigen::Index count, int n, double* image) {
  for (int i = 0; i < n; ++i, image += rows, x += lanes) {
    count == lanes ? std::copy_n(x, lanes, image) : std::copy_n(x, count, image);
  }
}

/// Of the rows of `image` [column][row], as many at once as a line of memory holds.
void of_rows(const Length& length, Transform transform, double* image, Eigen::Index rows) {
  const int n = length.n;
  std::vector<double> x(static_cast<std::size_t>(2 * lanes * n), 0.0), y = x;
  for (Eigen::Index row = 0; row < rows; row += 2 * lanes) {
    const auto for_halves = [&](const auto& work) {
      for (Eigen::Index half = 0; half < 2 && row + half * lanes < rows; ++half) {
        const Eigen::Index first = row + half * lanes;
        work(image + first, std::min(lanes, rows - first), x.data() + half * lanes * n);
      }
    };
    for_halves([&](const double* at, Eigen::Index count, double* half) {
      take_rows(at, rows, count, n, half);
    });
    for_halves(
        [&](const double*, Eigen::Index, double* half) { run(length, transform, half, y.data()); });
    for_halves([&](double* at, Eigen::Index count, const double* half) {
      put_rows(half, rows, count, n, at);
    });
  }
}

/// Of the columns of `image` [column][value].
void of_columns(const Length& length, Transform transform, double* image, Eigen::Index columns) {
  const int n = length.n;
  std::vector<double> x(static_cast<std::size_t>(lanes * n), 0.0), y = x;
  for (Eigen::Index column = 0; column < columns; column += lanes) {
    double* const first = image + column * n;
    const Eigen::Index count = std::min(lanes, columns - column);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index k = 0; k < count; ++k) x[i * lanes + k] = first[k * n + i];
    }
    run(length, transform, x.data(), y.data());
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index k = 0; k < count; ++k) first[k * n + i] = x[i * lanes + k];
    }
  }
}

Eigen::MatrixXd columns_of(const Length& length, Transform transform, Eigen::MatrixXd values) {
  of_columns(length, transform, values.data(), values.cols());
  return values;
}

/// Of an image [b][a], along both axes.
void of_image(const Length& a, const Length& b, Transform transform, double* image) {
  of_rows(b, transform, image, a.n);
  of_columns(a, transform, image, b.n);
}

}  // namespace

CosineTransform::CosineTransform(int n) : length_(make_length(n)) {}

Eigen::MatrixXd CosineTransform::forward(const Eigen::MatrixXd& values) const {
  return columns_of(*length_, transform_two, values);
}
Eigen::MatrixXd CosineTransform::inverse(const Eigen::MatrixXd& frequencies) const {
  return columns_of(*length_, invert_two, frequencies);
}

void to_waves(const CosineTransform& a, const CosineTransform& b, double* image) {
  of_image(a.length(), b.length(), transform_two, image);
}
void from_waves(const CosineTransform& a, const CosineTransform& b, double* frequencies) {
  of_image(a.length(), b.length(), invert_two, frequencies);
}
Eigen::MatrixXd to_waves(const CosineTransform& a, const CosineTransform& b,
                         Eigen::MatrixXd image) {
  to_waves(a, b, image.data());
  return image;
}
Eigen::MatrixXd from_waves(const CosineTransform& a, const CosineTransform& b,
                           Eigen::MatrixXd frequencies) {
  from_waves(a, b, frequencies.data());
  return frequencies;
}

}  // namespace kappamu
