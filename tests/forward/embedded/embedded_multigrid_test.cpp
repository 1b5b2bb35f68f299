// At most 15 iterations to 1e-6, whatever the shape, the cut and the medium. 256³ and 512³
// equivalent: docs/limits.md.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "embedded_test_tools.h"
#include "forward/embedded/discretisation.h"
#include "forward/embedded/equations/row_levels.h"

namespace kappamu::forward::embedded {
namespace {

constexpr int most_iterations = 15;
constexpr double tolerance = 1e-6;

const Eigen::Affine3d& turn() {
  static const Eigen::Affine3d tilted = [] {
    Eigen::Affine3d by = Eigen::Affine3d::Identity();
    by.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
    return by;
  }();
  return tilted;
}

/// A needle of 12 sides, 20 mm long, its tip a point.
TriangleMesh spike(double radius) {
  constexpr int sides = 12;
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {0.0, 0.0, 20.0}};
  for (int k = 0; k < sides; ++k) {
    const double angle = 2.0 * M_PI * k / sides;
    mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    mesh.triangles.push_back({0, 2 + (k + 1) % sides, 2 + k});
    mesh.triangles.push_back({1, 2 + k, 2 + (k + 1) % sides});
  }
  return mesh;
}

/// Random voxels of 1.25 mm, κ log-uniform over the contrast.
ObjectMedium random_medium(double contrast) {
  const GridShape shape{16, 16, 16, 1.25};
  auto volume = std::make_shared<Medium>(Medium{Volume<double>(shape), Volume<double>(shape)});
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (std::size_t k = 0; k < shape.cells(); ++k) {
    volume->kappa[k] = 0.3 * std::pow(contrast, uniform(generator));
    volume->mu[k] = 0.02 * (0.5 + uniform(generator));
  }
  return ObjectMedium(volume, Eigen::Affine3d::Identity(), Wrap::mirror);
}

/// Iterations under light at one triangle.
int iterations(const TriangleMesh& mesh, const ObjectMedium& medium, int level) {
  const auto rays = make_caster(mesh);
  Octree tree(mesh);
  tree.refine_surface(level);
  CutMesh cut = cut_mesh(tree, mesh, *rays);
  const std::array media{&medium};
  const Discretisation d(std::move(tree), std::move(cut), media, boundary_constants(1.3).A);
  std::vector<Load> b(1, {0, std::vector<double>(d.levels.unknowns(), 0.0)});
  std::vector<std::vector<double>> x;
  std::vector<double> flux(mesh.triangles.size(), 0.0);
  flux[flux.size() / 2] = 1.0;
  add_surface_load(d.mesh, d.space(), flux, b[0].power);
  const CgReport report =
      linear::make_host_solver(row_levels_of(d.levels))->solve(b, x, {tolerance, 100});
  EXPECT_TRUE(report.converged);
  return report.iterations;
}

const ObjectMedium& milky() {
  static const ObjectMedium medium(Coefficients{0.3, 0.001});
  return medium;
}

TEST(EmbeddedMultigrid, OnSmoothShapesAtEveryResolution) {
  const TriangleMesh mesh = icosphere(10.0, 3, {0.1, 0.2, 0.3});
  for (const int level : {3, 4, 5}) {
    EXPECT_LE(iterations(mesh, milky(), level), most_iterations) << level;
  }
}

TEST(EmbeddedMultigrid, OnSheetsThinnerThanACube) {
  for (const double thickness : {1.0, 0.1, 0.01}) {
    const TriangleMesh mesh = transformed(box({20.0, 20.0, thickness}, 8), turn());
    EXPECT_LE(iterations(mesh, milky(), 6), most_iterations) << thickness;
  }
}

TEST(EmbeddedMultigrid, OnSheetsFarThinnerThanACube) {
  // 1 µm in cubes of 0.65 mm: functions that vanish on the sheet have nearly no energy.
  EXPECT_LE(iterations(transformed(box({20.0, 20.0, 0.001}, 8), turn()), milky(), 5),
            most_iterations);
}

TEST(EmbeddedMultigrid, OnSpikesThinnerThanACube) {
  for (const double radius : {1.0, 0.01}) {
    const TriangleMesh mesh = transformed(spike(radius), turn());
    for (const int level : {3, 5, 6, 7}) {
      EXPECT_LE(iterations(mesh, milky(), level), most_iterations) << radius << " " << level;
    }
  }
}

TEST(EmbeddedMultigrid, UnderContrast) {
  const TriangleMesh mesh = icosphere(10.0, 3, {10.1, 9.9, 10.2});
  for (const double contrast : {1e2, 1e4}) {
    for (const int level : {4, 5}) {
      EXPECT_LE(iterations(mesh, random_medium(contrast), level), most_iterations)
          << contrast << " " << level;
    }
  }
}

TEST(EmbeddedMultigrid, WithVanishingCuts) {
  // A box whose upper y face lies a share of a cube beyond a face of cubes. Its longest edge, and
  // with it the root, stay.
  const Octree root(box({20.0, 20.0, 20.0}, 1));
  const double edge = std::ldexp(root.edge_mm(), -4);
  for (const double share : {1e-3, 1e-5, 1e-7, 1e-10}) {
    TriangleMesh mesh = box({20.0, 20.0, 20.0}, 1);
    // The root's corner moves with the box's centre, so that the height decides itself by
    // iteration.
    double height = 18.0;
    for (int k = 0; k < 50; ++k) {
      const double corner = Octree(box({20.0, height, 20.0}, 1)).to_mm({0.0, 0.0, 0.0}).y();
      height = corner + (15.0 + share) * edge;
    }
    mesh = box({20.0, height, 20.0}, 1);
    Octree tree(mesh);
    tree.refine_surface(4);
    const CutMesh cut = cut_mesh(tree, mesh, *make_caster(mesh));
    double smallest = 1.0;
    for (std::size_t k = 0; k < cut.cubes.size(); ++k) {
      smallest = std::min(smallest, cut.fraction(k));
    }
    EXPECT_LE(smallest, 1.01 * share);
    EXPECT_LE(iterations(mesh, milky(), 4), most_iterations) << share;
  }
}

}  // namespace
}  // namespace kappamu::forward::embedded
