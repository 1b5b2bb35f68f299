#include "forward/embedded/element.h"

#include <Eigen/Core>
#include <cmath>

namespace kappamu::forward::embedded {

namespace {

/// Coefficients of 1, x, x² of the product of the shape functions p and q of an edge.
constexpr std::array<std::array<std::array<double, 3>, 2>, 2> product{
    {{{{1.0, -2.0, 1.0}, {0.0, 1.0, -1.0}}}, {{{0.0, 1.0, -1.0}, {0.0, 0.0, 1.0}}}}};

/// ∫ of the product of two polynomials given per axis.
double integral(const Moments& moments, const std::array<double, 3>& x,
                const std::array<double, 3>& y, const std::array<double, 3>& z) {
  double sum = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t b = 0; b < 3; ++b) {
      const double yz = y[b] * z[c];
      for (std::size_t a = 0; a < 3; ++a) sum += x[a] * yz * moments[a + 3 * b + 9 * c];
    }
  }
  return sum;
}

/// ∫ ∇N_i·∇N_j and ∫ N_i N_j.
struct Integrals {
  double stiffness = 0.0, mass = 0.0;
};

Integrals integrals(const Moments& moments, std::size_t i, std::size_t j) {
  std::array<std::array<double, 3>, 3> p;
  for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = product[i >> axis & 1][j >> axis & 1];
  Integrals result;
  result.mass = integral(moments, p[0], p[1], p[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto derivative = p;
    derivative[axis] = {(i >> axis & 1) == (j >> axis & 1) ? 1.0 : -1.0, 0.0, 0.0};
    result.stiffness += integral(moments, derivative[0], derivative[1], derivative[2]);
  }
  return result;
}

using EightPairs = std::array<Integrals, 8>;

/// Of the whole cube, by the axes in which two corners differ.
const EightPairs& whole_integrals() {
  static const EightPairs table = [] {
    Moments moments;
    for (std::size_t k = 0; k < 27; ++k) {
      const double a = static_cast<double>(k % 3), b = static_cast<double>(k / 3 % 3),
                   c = static_cast<double>(k / 9);
      moments[k] = 1.0 / ((a + 1.0) * (b + 1.0) * (c + 1.0));
    }
    EightPairs pairs;
    for (std::size_t differing = 0; differing < 8; ++differing) {
      pairs[differing] = integrals(moments, 0, differing);
    }
    return pairs;
  }();
  return table;
}

}  // namespace

Element whole_element(const Coefficients& coefficients, double h) {
  Element element;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) {
      const Integrals& pair = whole_integrals()[i ^ j];
      element[8 * i + j] =
          coefficients.kappa * h * pair.stiffness + coefficients.mu * h * h * h * pair.mass;
    }
  }
  return element;
}

Element cut_element(const Coefficients& coefficients, double h, const Moments& volume,
                    const Moments& surface, double A) {
  Element element;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = i; j < 8; ++j) {
      const Integrals inside = integrals(volume, i, j);
      const double value = coefficients.kappa * h * inside.stiffness +
                           coefficients.mu * h * h * h * inside.mass +
                           h * h / (2.0 * A) * integrals(surface, i, j).mass;
      element[8 * i + j] = element[8 * j + i] = value;
    }
  }
  return element;
}

double parent_weight(int octant, int corner, int i) {
  double weight = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double x = ((octant >> axis & 1) + (corner >> axis & 1)) / 2.0;
    weight *= (i >> axis & 1) != 0 ? x : 1.0 - x;
  }
  return weight;
}

void add_child(Element& parent, const Element& child, int octant) {
  using Matrix = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>;
  static const std::array<Matrix, 8> weights = [] {
    std::array<Matrix, 8> table;
    for (int o = 0; o < 8; ++o) {
      for (int corner = 0; corner < 8; ++corner) {
        for (int i = 0; i < 8; ++i) {
          table[static_cast<std::size_t>(o)](corner, i) = parent_weight(o, corner, i);
        }
      }
    }
    return table;
  }();
  const Matrix& p = weights[static_cast<std::size_t>(octant)];
  Eigen::Map<Matrix> sum(parent.data());
  const Eigen::Map<const Matrix> a(child.data());
  const Matrix half = a * p;
  sum.noalias() += p.transpose() * half;
}

double scaled_bound(const Element& element) {
  // λ ≤ ‖B⁸‖^⅛ in the row-sum norm, B = D^−½ a D^−½.
  using Matrix = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>;
  const Eigen::Map<const Matrix> a(element.data());
  Eigen::Matrix<double, 8, 1> scale;
  for (int i = 0; i < 8; ++i) scale[i] = a(i, i) > 0.0 ? 1.0 / std::sqrt(a(i, i)) : 0.0;
  Matrix power = scale.asDiagonal() * a * scale.asDiagonal();
  for (int square = 0; square < 3; ++square) power = (power * power).eval();
  return std::pow(power.cwiseAbs().rowwise().sum().maxCoeff(), 1.0 / 8.0);
}

}  // namespace kappamu::forward::embedded
