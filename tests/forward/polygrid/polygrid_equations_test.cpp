// The equations of a polygrid: laws of the matrix, and their order on maps and balls with closed
// forms. Beams and surfaces of meshes: polygrid_light_test.cpp.
#include "forward/polygrid/equations/equations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "../embedded/exact_sphere.h"
#include "core/error.h"
#include "core/numbers/dot.h"
#include "core/optics.h"
#include "forward/polygrid/linear_solver.h"
#include "tests/cases/made_polygrid.h"
#include "tests/cases/polygrid_reference.h"

namespace kappamu::forward::polygrid {
namespace {

using Eigen::Vector3d;
using embedded::ExactSphere;
using Vector = std::vector<double>;

const double A = boundary_constants(1.3).A;
constexpr Coefficients medium{0.2, 0.02};

std::vector<Coefficients> everywhere(const Polygrid& grid, const Coefficients& coefficients) {
  return std::vector<Coefficients>(grid.cell.size(), coefficients);
}

/// κ and μ drawn within a factor of ten either way.
std::vector<Coefficients> drawn(const Polygrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> power(-1.0, 1.0);
  std::vector<Coefficients> result;
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    result.push_back({0.2 * std::pow(10.0, power(random)), 0.02 * std::pow(10.0, power(random))});
  }
  return result;
}

Vector product(const Pattern& pattern, const Vector& value, const Vector& x) {
  Vector y(x.size(), 0.0);
  for (std::size_t i = 0; i < y.size(); ++i) {
    for (int k = pattern.start[i]; k < pattern.start[i + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const auto j = static_cast<std::size_t>(pattern.column[at]);
      y[i] += value[at] * x[j];
      if (j != i) y[j] += value[at] * x[i];
    }
  }
  return y;
}

/// Points of a side with their weights [mm²], its corners' functions there, and the normal.
struct SidePoint {
  Vector3d at, normal;
  double weight = 0.0;
  std::array<double, 4> function{};
};
template <class Visit>
void each_side_point(const Polygrid& grid, const Visit& visit) {
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    std::array<std::size_t, 4> corner{};
    std::array<Vector3d, 4> p;
    for (std::size_t i = 0; i < 4; ++i) {
      corner[i] = static_cast<std::size_t>(boundary_corners(grid, b)[i]);
      p[i] = grid.corner[corner[i]];
    }
    const double off = std::sqrt(1.0 / 12.0);
    for (const double v : {0.5 - off, 0.5 + off}) {
      for (const double u : {0.5 - off, 0.5 + off}) {
        SidePoint point;
        point.function = {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
        point.at = Vector3d::Zero();
        for (std::size_t i = 0; i < 4; ++i) point.at += point.function[i] * p[i];
        const Vector3d across = ((1 - v) * (p[1] - p[0]) + v * (p[2] - p[3]))
                                    .cross((1 - u) * (p[3] - p[0]) + u * (p[2] - p[1]));
        point.weight = 0.25 * across.norm();
        point.normal = across.normalized() * (across.dot(grid.normal[b]) > 0.0 ? 1.0 : -1.0);
        visit(corner, point);
      }
    }
  }
}

/// ∫ q N/(2A) dA.
template <class Q>
Vector boundary_load(const Polygrid& grid, const Q& q) {
  Vector load(grid.corner.size(), 0.0);
  each_side_point(grid, [&](const auto& corner, const SidePoint& point) {
    for (std::size_t i = 0; i < 4; ++i) {
      load[corner[i]] += point.weight * point.function[i] * q(point.at, point.normal) / (2.0 * A);
    }
  });
  return load;
}

Vector solved(const Equations& equations, const MediumValues& values, const Vector& load) {
  const auto solver = make_reference_solver(equations);
  solver->set_media({values});
  std::vector<Vector> x;
  const CgReport report = solver->solve({{0, load}}, x, 1e-10, 5000);
  EXPECT_TRUE(report.converged);
  return x.front();
}

/// Relative 2-norm over the boundary of φ against `exact`.
template <class Exact>
double surface_error(const Polygrid& grid, const Vector& x, const Exact& exact) {
  double difference = 0.0, size = 0.0;
  each_side_point(grid, [&](const auto& corner, const SidePoint& point) {
    double value = 0.0;
    for (std::size_t i = 0; i < 4; ++i) value += point.function[i] * x[corner[i]];
    const double expected = exact(point.at);
    difference += point.weight * (value - expected) * (value - expected);
    size += point.weight * expected * expected;
  });
  return std::sqrt(difference / size);
}

TEST(PolygridEquations, AreSymmetricAndPositive) {
  const Polygrid grid = bent_polygrid({7, 5, 3});
  const Equations equations(grid, A);
  const MediumValues values = equations.values(drawn(grid, 1));
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 3; ++trial) {
    Vector x(equations.unknowns()), y(equations.unknowns());
    for (double& v : x) v = normal(random);
    for (double& v : y) v = normal(random);
    const double x_x = dot(x, product(equations.matrix(), values.value, x));
    EXPECT_GT(x_x, 0.0);
    EXPECT_NEAR(dot(x, product(equations.matrix(), values.value, y)),
                dot(y, product(equations.matrix(), values.value, x)), 1e-13 * x_x);
  }
}

// What a constant loses is absorption and boundary alone.
TEST(PolygridEquations, ConserveThePowerOfAConstant) {
  const Polygrid grid = bent_polygrid({7, 5, 3});
  const Equations equations(grid, A);
  const std::vector<Coefficients> coefficients = drawn(grid, 3);
  const MediumValues values = equations.values(coefficients);
  const Vector one(equations.unknowns(), 1.0);
  const Vector lost = product(equations.matrix(), values.value, one);
  const Vector& absorbed = values.absorption;
  double largest = 0.0;
  for (const double v : values.value) largest = std::max(largest, std::abs(v));
  for (std::size_t i = 0; i < lost.size(); ++i) {
    EXPECT_NEAR(lost[i], values.leak[i], 1e-12 * largest);
    EXPECT_NEAR(values.leak[i], absorbed[i] + equations.boundary_share()[i] / (2.0 * A),
                1e-12 * largest);
  }
}

// Rows made anew about the cells that changed are those of all coefficients.
TEST(PolygridEquations, RenewTheRowsOfChangedCells) {
  const Polygrid grid = bent_polygrid({7, 5, 3});
  const Equations equations(grid, A);
  std::vector<Coefficients> of_cell = drawn(grid, 3);
  MediumValues values = equations.values(of_cell);
  std::set<int> about;
  for (const std::size_t cell : {std::size_t{11}, std::size_t{12}, std::size_t{70}}) {
    of_cell[cell] = {7.0, 0.3};
    about.insert(grid.cell_corners[cell].begin(), grid.cell_corners[cell].end());
  }
  const std::vector<int> rows(about.begin(), about.end());
  const MediumValues expected = equations.values(of_cell);
  EXPECT_NE(values.value, expected.value);
  equations.renew(of_cell, rows, values);
  EXPECT_EQ(values.value, expected.value);
  EXPECT_EQ(values.link, expected.link);
  EXPECT_EQ(values.leak, expected.leak);
  EXPECT_EQ(values.absorption, expected.absorption);
}

// A constant gradient has no sources inside, however the cells are deformed.
TEST(PolygridEquations, AreExactForLinearFunctionsOnDeformedCells) {
  Polygrid grid = bent_polygrid({5, 4, 4});
  std::mt19937 random(4);
  std::uniform_real_distribution<double> shift(-0.08, 0.08);
  for (Vector3d& corner : grid.corner) {
    corner += Vector3d(shift(random), shift(random), shift(random));
  }
  const Equations equations(grid, A);
  const MediumValues values = equations.values(everywhere(grid, {1.0, 0.0}));
  Vector x;
  for (const Vector3d& corner : grid.corner) x.push_back(corner.dot(Vector3d(1.0, -2.0, 0.5)));
  const Vector flux = product(equations.matrix(), values.value, x);
  int inside = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (equations.boundary_share()[i] > 0.0) continue;
    EXPECT_NEAR(flux[i], 0.0, 1e-12);
    ++inside;
  }
  EXPECT_EQ(inside, 4 * 3 * 3);
}

// No coupling of diffusion is of a sign that could overshoot; even light on one medium keeps φ
// below q. The masses of absorption and boundary are not lumped, for accuracy: at an edge of the
// light, among coefficients a hundred apart, φ overshoots by a few hundredths.
TEST(PolygridEquations, KeepTheMaximumPrincipleOnACube) {
  const Polygrid grid = box_polygrid({6, 6, 6}, {3, 3, 3});
  const Equations equations(grid, A);
  const MediumValues values = equations.values(drawn(grid, 5));
  const MediumValues of_boundary = equations.values(everywhere(grid, {0.0, 0.0}));
  const std::vector<Coefficients> absorbing = drawn(grid, 5);
  std::vector<Coefficients> without = absorbing;
  for (Coefficients& c : without) c.mu = 0.0;
  const MediumValues diffusing = equations.values(without);
  for (std::size_t i = 0; i < equations.unknowns(); ++i) {
    for (int k = equations.matrix().start[i]; k < equations.matrix().start[i + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (equations.matrix().column[at] == static_cast<int>(i)) continue;
      EXPECT_LE(diffusing.value[at] - of_boundary.value[at], 1e-15);
    }
  }
  const auto range = [&](const MediumValues& of, const auto& q) {
    const Vector x = solved(equations, of, boundary_load(grid, q));
    return std::pair{*std::min_element(x.begin(), x.end()), *std::max_element(x.begin(), x.end())};
  };
  const auto even = range(equations.values(everywhere(grid, medium)),
                          [](const Vector3d&, const auto&) { return 1.0; });
  EXPECT_GT(even.first, 0.0);
  EXPECT_LE(even.second, 1.0);
  constexpr double overshoot = 0.06;
  const auto half =
      range(values, [](const Vector3d& p, const auto&) { return p[0] < 1.5 ? 1.0 : 0.0; });
  EXPECT_GT(half.first, -overshoot);
  EXPECT_LT(half.second, 1.0 + overshoot);
}

TEST(PolygridEquations, RefuseAnInvertedCell) {
  Polygrid grid = box_polygrid({3, 3, 3}, {1, 1, 1});
  std::swap(grid.cell_corners[4][0], grid.cell_corners[4][7]);
  std::swap(grid.cell_corners[4][1], grid.cell_corners[4][6]);
  std::swap(grid.cell_corners[4][2], grid.cell_corners[4][5]);
  std::swap(grid.cell_corners[4][3], grid.cell_corners[4][4]);
  EXPECT_THROW(Equations(grid, A), InputError);
}

// φ = e^(k·x) with κ|k|² = μ has no sources; its q follows from the normal.
TEST(PolygridOrder, TwoOnABentBox) {
  const Vector3d k = std::sqrt(medium.mu / medium.kappa) * Vector3d(2, -3, 6) / 7.0;
  const auto exact = [&](const Vector3d& p) { return std::exp(k.dot(p)); };
  Vector errors;
  for (const int n : {4, 8, 16}) {
    const Polygrid grid = bent_polygrid({2 * n, n, n});
    const Equations equations(grid, A);
    const MediumValues values = equations.values(everywhere(grid, medium));
    const Vector x = solved(equations, values,
                            boundary_load(grid, [&](const Vector3d& p, const Vector3d& normal) {
                              return exact(p) * (1.0 + 2.0 * A * medium.kappa * k.dot(normal));
                            }));
    errors.push_back(surface_error(grid, x, exact));
  }
  EXPECT_GE(std::log2(errors[1] / errors[2]), 1.9) << errors[1] << " to " << errors[2];
  EXPECT_LE(errors[2], 1e-4);
}

// The map of the cube bends its edges flat: cells there degenerate under refinement, which costs a
// part of the order.
TEST(PolygridOrder, NearlyTwoOnTheBallLitFromOutside) {
  const ExactSphere sphere{10.0, medium, A};
  const Vector3d axis = Vector3d(1, 2, 3).normalized();
  for (int l = 0; l < 3; ++l) {
    Vector terms(static_cast<std::size_t>(l) + 1, 0.0);
    terms.back() = 1.0;
    const auto legendre = [&](const Vector3d& p) {
      return ExactSphere::legendre_sum(terms, axis.dot(p.normalized()));
    };
    Vector errors;
    for (const int n : {8, 16, 32}) {
      const Polygrid grid = ball_polygrid(n, sphere.radius);
      const Equations equations(grid, A);
      const Vector x =
          solved(equations, equations.values(everywhere(grid, medium)),
                 boundary_load(grid, [&](const Vector3d& p, const auto&) { return legendre(p); }));
      errors.push_back(surface_error(
          grid, x, [&](const Vector3d& p) { return sphere.lit_from_outside(l) * legendre(p); }));
    }
    EXPECT_GE(std::log2(errors[0] / errors[2]) / 2.0, 1.45) << errors[0] << " to " << errors[2];
    EXPECT_LE(errors[2], 2e-3);
  }
}

TEST(PolygridOrder, NearlyTwoOnTheBallLitFromInside) {
  const ExactSphere sphere{5.0, medium, A};
  const Vector3d source(0.71, -1.13, 0.59);
  const Vector terms = sphere.lit_from_inside(source.norm());
  Vector errors;
  for (const int n : {8, 16, 32}) {
    const Polygrid grid = ball_polygrid(n, sphere.radius);
    const Equations equations(grid, A);
    // In the cell about the source, shared by its functions.
    Vector load(equations.unknowns(), 0.0);
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < grid.cell.size(); ++k) {
      if ((grid.node[k] - source).norm() < (grid.node[nearest] - source).norm()) nearest = k;
    }
    Vector3d local = Vector3d::Constant(0.5);
    for (int step = 0; step < 20; ++step) {
      Vector3d off = -source;
      Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
      for (int c = 0; c < 8; ++c) {
        const Vector3d& p = grid.corner[static_cast<std::size_t>(
            grid.cell_corners[nearest][static_cast<std::size_t>(c)])];
        off += shape_functions(local)[static_cast<std::size_t>(c)] * p;
        for (int a = 0; a < 3; ++a) {
          Vector3d to = local, from = local;
          to[a] = 1.0;
          from[a] = 0.0;
          jacobian.col(a) += (shape_functions(to)[static_cast<std::size_t>(c)] -
                              shape_functions(from)[static_cast<std::size_t>(c)]) *
                             p;
        }
      }
      local -= jacobian.inverse() * off;
    }
    ASSERT_TRUE((local.array() >= 0.0).all() && (local.array() <= 1.0).all());
    for (std::size_t c = 0; c < 8; ++c) {
      load[static_cast<std::size_t>(grid.cell_corners[nearest][c])] = shape_functions(local)[c];
    }
    const Vector x = solved(equations, equations.values(everywhere(grid, medium)), load);
    errors.push_back(surface_error(grid, x, [&](const Vector3d& p) {
      return ExactSphere::legendre_sum(terms, source.dot(p) / source.norm() / p.norm());
    }));
  }
  EXPECT_GE(std::log2(errors[0] / errors[2]) / 2.0, 1.45) << errors[0] << " to " << errors[2];
  EXPECT_LE(errors[2], 5e-3);
}

}  // namespace
}  // namespace kappamu::forward::polygrid
