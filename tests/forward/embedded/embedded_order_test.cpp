// Convergence to the exact sphere, and the laws of the discrete equations. Meshes are refined
// together with the triangles: the faceted sphere's own error is of order 2 too.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/numbers/dot.h"
#include "cube_by_cube.h"
#include "embedded_test_tools.h"
#include "exact_sphere.h"
#include "forward/embedded/discretisation.h"
#include "forward/embedded/equations/row_levels.h"

namespace kappamu::forward::embedded {
namespace {

constexpr double eta = 1.3;
const Eigen::Vector3d centre(0.123, 0.2, -0.31);
/// Far below the discretisation's error.
constexpr double solved = 1e-9;

Octree uniform_tree(const TriangleMesh& mesh, int level) {
  Octree tree(mesh);
  for (int split = 0; split < level; ++split) tree.refine_each(tree.leaves());
  return tree;
}

struct Errors {
  double two = 0.0, most = 0.0;  ///< relative, of φ on the surface
};

/// Errors of the mean fluence of every triangle against `exact` at its centroid's direction.
template <class Lighting, class Exact>
Errors sphere_errors(int level, const ExactSphere& sphere, const Lighting& load,
                     const Exact& exact) {
  const TriangleMesh mesh = icosphere(sphere.radius, level, centre);
  const Surface surface = surface_of(mesh);
  const auto rays = make_caster(mesh);
  const ObjectMedium medium(sphere.medium);
  const std::array media{&medium};
  Octree tree = uniform_tree(mesh, level);
  CutMesh cut = cut_mesh(tree, mesh, *rays);
  const Discretisation d(std::move(tree), std::move(cut), media, sphere.A);
  std::vector<Load> b(1, {0, std::vector<double>(d.levels.unknowns(), 0.0)});
  std::vector<std::vector<double>> x;
  load(d, surface, b[0].power);
  EXPECT_TRUE(
      linear::make_host_solver(row_levels_of(d.levels))->solve(b, x, {solved, 50}).converged);
  const std::vector<double> means = triangle_means(d.mesh, d.space(), x[0], surface.size());
  double error = 0.0, norm = 0.0, most = 0.0, highest = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double wanted = exact((surface.position[t] - centre).normalized());
    error += surface.area[t] * std::pow(means[t] - wanted, 2);
    norm += surface.area[t] * wanted * wanted;
    most = std::max(most, std::abs(means[t] - wanted));
    highest = std::max(highest, std::abs(wanted));
  }
  return {std::sqrt(error / norm), most / highest};
}

void expect_second_order(const std::vector<Errors>& errors) {
  const double halvings = static_cast<double>(errors.size()) - 1.0;
  const double two = std::log2(errors.front().two / errors.back().two) / halvings;
  const double most = std::log2(errors.front().most / errors.back().most) / halvings;
  EXPECT_GE(two, 1.9) << errors.front().two << " to " << errors.back().two;
  EXPECT_GE(most, 1.7) << errors.front().most << " to " << errors.back().most;
}

ExactSphere test_sphere() {
  return {5.0, {0.2, 0.02}, boundary_constants(eta).A};
}

TEST(EmbeddedOrder, TwoOnTheSphereLitFromOutside) {
  const ExactSphere sphere = test_sphere();
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  const std::vector<double> light(3, 1.0);  // q, by Legendre polynomial
  std::vector<double> terms;
  for (int l = 0; l < 3; ++l) terms.push_back(sphere.lit_from_outside(l));
  std::vector<Errors> errors;
  for (const int level : {3, 4, 5}) {
    errors.push_back(sphere_errors(
        level, sphere,
        [&](const Discretisation& d, const Surface& surface, std::vector<double>& b) {
          std::vector<double> flux;
          for (const Eigen::Vector3d& p : surface.position) {
            const double cosine = axis.dot((p - centre).normalized());
            flux.push_back(ExactSphere::legendre_sum(light, cosine) / (2.0 * sphere.A));
          }
          add_surface_load(d.mesh, d.space(), flux, b);
        },
        [&](const Eigen::Vector3d& direction) {
          return ExactSphere::legendre_sum(terms, axis.dot(direction));
        }));
  }
  expect_second_order(errors);
}

TEST(EmbeddedOrder, TwoOnTheSphereLitFromInside) {
  const ExactSphere sphere = test_sphere();
  const Eigen::Vector3d source = centre + Eigen::Vector3d(0.71, -1.13, 0.59);
  const Eigen::Vector3d axis = (source - centre).normalized();
  const std::vector<double> terms = sphere.lit_from_inside((source - centre).norm());
  std::vector<Errors> errors;
  for (const int level : {3, 4, 5}) {
    errors.push_back(sphere_errors(
        level, sphere,
        [&](const Discretisation& d, const Surface&, std::vector<double>& b) {
          const Eigen::Vector3d at = d.tree.to_root(source);
          const int leaf = d.tree.leaf_at(at);
          const Cube& cube = d.tree.cube(leaf);
          const Eigen::Vector3d corner(cube.at[0], cube.at[1], cube.at[2]);
          add_load(d.space(),
                   static_cast<std::size_t>(d.mesh.cube_of_leaf[static_cast<std::size_t>(leaf)]),
                   shape_functions(std::ldexp(1.0, cube.level) * at - corner), b);
        },
        [&](const Eigen::Vector3d& direction) {
          return ExactSphere::legendre_sum(terms, axis.dot(direction));
        }));
  }
  expect_second_order(errors);
}

/// An octree with level jumps across the inside.
struct Small {
  TriangleMesh mesh = icosphere(5.0, 2, centre);
  std::unique_ptr<RayCaster> rays = make_caster(mesh);
  Octree tree{mesh};
  CutMesh cut;
  Elements elements;
  NodeSpace space;

  explicit Small(int level) {
    tree.refine_surface(level);
    cut = cut_mesh(tree, mesh, *rays);
    const ObjectMedium medium(Coefficients{0.2, 0.02});
    elements = cube_elements(cut, {cube_coefficients(cut, tree, medium)}, 2.34);
    space = NodeSpace(cut.cubes);
  }
  Levels levels() const { return make_levels(cut.cubes, elements); }
  std::vector<double> random(unsigned seed) const {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<double> values(space.unknowns());
    for (double& v : values) v = uniform(generator);
    return values;
  }
};

std::vector<double> product(const linear::RowMatrix<double>& matrix, const std::vector<double>& x) {
  std::vector<double> y(x.size());
  linear::for_products<1, false>(matrix, x.data(),
                                 [&](std::size_t row, const auto& sum) { y[row] = sum[0]; });
  return y;
}

TEST(EmbeddedEquations, RowsAreTheReference) {
  const Small small(5);
  const Levels levels = small.levels();
  const linear::RowMatrix<double> rows = make_row_levels(levels, {1, {0}}).level[0].equations;
  const std::vector<double> x = small.random(1);
  const std::vector<double> a = product(rows, x);
  const std::vector<double> b = reference_product(small.space, small.elements, 0, x);
  for (std::size_t u = 0; u < a.size(); ++u) ASSERT_NEAR(a[u], b[u], 1e-12);
}

TEST(EmbeddedEquations, AreSymmetricAndPositive) {
  const Small small(5);
  const Levels levels = small.levels();
  const linear::RowMatrix<double> rows = make_row_levels(levels, {1, {0}}).level[0].equations;
  for (const unsigned seed : {1U, 3U, 5U}) {
    const std::vector<double> x = small.random(seed), y = small.random(seed + 1);
    const std::vector<double> a_x = product(rows, x);
    const std::vector<double> a_y = product(rows, y);
    EXPECT_NEAR(dot(x, a_y), dot(y, a_x), 1e-11 * std::abs(dot(x, a_x)));
    EXPECT_GT(dot(x, a_x), 0.0);
  }
}

TEST(EmbeddedEquations, LinearFunctionsHaveNoFluxInside) {
  // Hanging nodes included: a trilinear space holds linear functions, and without absorption only
  // the surface contributes to their equations.
  const Small small(5);
  Elements stiffness = small.elements;
  stiffness = cube_elements(small.cut,
                            {std::vector<Coefficients>(small.cut.cubes.size(), {0.2, 0.0})}, 1e30);
  const NodeSpace& space = small.space;
  std::vector<double> x(space.unknowns());
  std::vector<char> near_surface(space.unknowns(), 0);
  for (std::size_t k = 0; k < space.cubes(); ++k) {
    for (std::size_t i = 0; i < 8; ++i) {
      const auto parts = space.parts(k, i);
      const Cube& cube = small.cut.cubes[k];
      const double edge = std::ldexp(1.0, -cube.level);
      if (parts.size() == 1) {
        x[static_cast<std::size_t>(parts[0])] =
            edge * ((cube.at[0] + (i & 1)) + 2.0 * (cube.at[1] + (i >> 1 & 1)) -
                    3.0 * (cube.at[2] + (i >> 2 & 1)));
      }
      if (small.cut.cut[k] < 0) continue;
      for (const int u : parts) near_surface[static_cast<std::size_t>(u)] = 1;
    }
  }
  const std::vector<double> y = reference_product(space, stiffness, 0, x);
  int inside = 0;
  for (std::size_t u = 0; u < y.size(); ++u) {
    if (near_surface[u] != 0) continue;
    ++inside;
    ASSERT_NEAR(y[u], 0.0, 1e-13);
  }
  EXPECT_GT(inside, 300);
}

TEST(EmbeddedEquations, MultigridSolvesAsTheReferenceDoes) {
  const Small small(4);
  const Levels levels = small.levels();
  std::vector<Load> b;
  std::vector<std::vector<double>> x;
  for (unsigned light = 0; light < 3; ++light) {
    b.push_back({0, reference_product(small.space, small.elements, 0, small.random(10 + light))});
  }
  EXPECT_TRUE(linear::make_host_solver(row_levels_of(levels))->solve(b, x, {1e-10, 50}).converged);
  const std::vector<double> y =
      reference_solution(small.space, small.elements, 0, b[2].power, 1e-11);
  std::vector<double> error = y;
  for (std::size_t u = 0; u < y.size(); ++u) error[u] -= x[2][u];
  const auto energy = [&](const std::vector<double>& v) {
    return dot(v, reference_product(small.space, small.elements, 0, v));
  };
  constexpr double both_residuals = 1e-7;  // 1e-10 and 1e-11, times the root of the condition
  EXPECT_LE(std::sqrt(energy(error) / energy(y)), both_residuals);
}

}  // namespace
}  // namespace kappamu::forward::embedded
