#include "forward/embedded/equations/element.h"

#include <Eigen/Core>
#include <cmath>

namespace kappamu::forward::embedded {

namespace {

/// Per axis the products of an edge's two shape functions: N_0 N_0, N_0 N_1, N_1 N_1.
constexpr std::array<std::array<double, 3>, 3> product{
    {{1.0, -2.0, 1.0}, {0.0, 1.0, -1.0}, {0.0, 0.0, 1.0}}};

/// ∫ of the products of shape functions per axis, [x + 3 y + 9 z] as `product` numbers them.
using Products = std::array<double, 27>;

Products products(const Moments& moments) {
  Products result = moments;
  for (const std::size_t stride : {1UL, 3UL, 9UL}) {
    Products next;
    for (std::size_t k = 0; k < 27; ++k) {
      const std::size_t kind = k / stride % 3, first = k - kind * stride;
      double sum = 0.0;
      for (std::size_t power = 0; power < 3; ++power) {
        sum += product[kind][power] * result[first + power * stride];
      }
      next[k] = sum;
    }
    result = next;
  }
  return result;
}

/// Sums over one axis of the products: with N_0 + N_1 = 1 the integrals without that axis' shape
/// functions.
Products without_axis(const Products& all, std::size_t stride) {
  Products result{};
  for (std::size_t k = 0; k < 27; ++k) {
    if (k / stride % 3 != 0) continue;
    result[k] = all[k] + 2.0 * all[k + stride] + all[k + 2 * stride];
  }
  return result;
}

std::size_t kind(std::size_t i, std::size_t j, std::size_t axis) {
  return (i >> axis & 1) + (j >> axis & 1);
}

}  // namespace

ElementIntegrals element_integrals(const Moments& volume, const Moments& surface) {
  const Products inside = products(volume), on_surface = products(surface);
  constexpr std::array<std::size_t, 3> stride{1, 3, 9};
  std::array<Products, 3> gradient;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    gradient[axis] = without_axis(inside, stride[axis]);
  }
  ElementIntegrals result;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = i; j < 8; ++j) {
      const std::size_t place = Element::place(i, j);
      const std::size_t all = kind(i, j, 0) + 3 * kind(i, j, 1) + 9 * kind(i, j, 2);
      result.mass.entry[place] = inside[all];
      result.surface.entry[place] = on_surface[all];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double value = gradient[axis][all - kind(i, j, axis) * stride[axis]];
        result.stiffness.entry[place] += (i >> axis & 1) == (j >> axis & 1) ? value : -value;
      }
    }
  }
  return result;
}

const ElementIntegrals& whole_integrals() {
  static const ElementIntegrals whole = [] {
    Moments moments;
    for (std::size_t k = 0; k < 27; ++k) {
      const double a = static_cast<double>(k % 3), b = static_cast<double>(k / 3 % 3),
                   c = static_cast<double>(k / 9);
      moments[k] = 1.0 / ((a + 1.0) * (b + 1.0) * (c + 1.0));
    }
    return element_integrals(moments, Moments{});
  }();
  return whole;
}

Element element_of(const ElementIntegrals& integrals, const Coefficients& coefficients, double h,
                   double A) {
  const double stiffness = coefficients.kappa * h, mass = coefficients.mu * h * h * h,
               surface = h * h / (2.0 * A);
  Element element;
  for (std::size_t k = 0; k < Element::entries; ++k) {
    element.entry[k] = stiffness * integrals.stiffness.entry[k] + mass * integrals.mass.entry[k] +
                       surface * integrals.surface.entry[k];
  }
  // Rounding of the moments, some 1e-16 of the whole cube's, must not make a vanishing part of a
  // cube indefinite.
  for (std::size_t i = 0; i < 8; ++i) element.entry[Element::place(i, i)] += 1e-14 * stiffness;
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
  // Pᵀ a P axis by axis: along each, one corner is the parent's own, the other the middle of its
  // edge.
  std::array<std::array<double, 8>, 8> a;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) a[i][j] = child(i, j);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t bit = std::size_t{1} << axis;
    const bool upper = (static_cast<std::size_t>(octant) & bit) != 0;
    for (std::size_t i = 0; i < 8; ++i) {
      if ((i & bit) != 0) continue;
      const std::size_t own = upper ? i | bit : i, middle = upper ? i : i | bit;
      for (std::size_t j = 0; j < 8; ++j) {
        a[middle][j] *= 0.5;
        a[own][j] += a[middle][j];
      }
    }
    for (std::size_t j = 0; j < 8; ++j) {
      if ((j & bit) != 0) continue;
      const std::size_t own = upper ? j | bit : j, middle = upper ? j : j | bit;
      for (std::size_t i = 0; i < 8; ++i) {
        a[i][middle] *= 0.5;
        a[i][own] += a[i][middle];
      }
    }
  }
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = i; j < 8; ++j) parent.entry[Element::place(i, j)] += a[i][j];
  }
}

double scaled_bound(const Element& element) {
  // λ ≤ ‖B⁸‖^⅛ in the row-sum norm, B = D^−½ a D^−½; single precision costs 1e-6 of it.
  using Matrix = Eigen::Matrix<float, 8, 8>;
  Eigen::Matrix<double, 8, 1> scale;
  for (Eigen::Index i = 0; i < 8; ++i) {
    const double own = element(static_cast<std::size_t>(i), static_cast<std::size_t>(i));
    scale[i] = own > 0.0 ? 1.0 / std::sqrt(own) : 0.0;
  }
  Matrix power;
  for (Eigen::Index i = 0; i < 8; ++i) {
    for (Eigen::Index j = i; j < 8; ++j) {
      const double value = element(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
      power(i, j) = power(j, i) = static_cast<float>(scale[i] * scale[j] * value);
    }
  }
  for (int square = 0; square < 3; ++square) power = power.lazyProduct(power).eval();
  constexpr double rounding = 1.0 + 1e-5;
  return rounding *
         std::pow(static_cast<double>(power.cwiseAbs().rowwise().sum().maxCoeff()), 1.0 / 8.0);
}

}  // namespace kappamu::forward::embedded
