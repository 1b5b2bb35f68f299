// The energy of cells: its minimum, its gradient, and that it forbids inversion.
#include "forward/polygrid/shape/cell_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mesh/lattice_box.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> box(const Vector3d& size) {
  std::vector<Vector3d> corners;
  for (int b = 0; b < 8; ++b) {
    corners.emplace_back(lattice_corner(b).cast<double>().cwiseProduct(size));
  }
  return corners;
}

const std::vector<std::array<int, 8>> one_cell{{0, 1, 2, 3, 4, 5, 6, 7}};

std::vector<TargetCell> target_of(const Vector3d& size) {
  TargetCell target;
  target.inverse_edge = size.array().inverse();
  return {target};
}

double energy_of(const CellEnergy& energy, const std::vector<TargetCell>& target,
                 const std::vector<Vector3d>& corner, std::vector<Vector3d>& gradient) {
  return CellEnergies(one_cell, target, 8)(energy, corner, gradient);
}

TEST(CellEnergy, IsLeastForTheTarget) {
  const Vector3d size(2.0, 0.5, 1.0);
  for (const int power : {1, 2, 3}) {
    const CellEnergy energy{0.2, 0.0, power};
    std::vector<Vector3d> gradient(8, Vector3d::Zero());
    EXPECT_NEAR(energy_of(energy, target_of(size), box(size), gradient), 8.0 * std::pow(1.2, power),
                1e-12);
    for (const Vector3d& g : gradient) EXPECT_NEAR(g.norm(), 0.0, 1e-12);
    EXPECT_GT(energy_of(energy, target_of(size), box(1.1 * size), gradient),
              8.0 * std::pow(1.2, power));
  }
}

TEST(CellEnergy, GradientIsTheDerivative) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 0.2);
  std::vector<Vector3d> corner = box(Vector3d::Ones());
  std::vector<Vector3d> direction(8);
  for (int b = 0; b < 8; ++b) {
    for (int axis = 0; axis < 3; ++axis) {
      corner[static_cast<std::size_t>(b)][axis] += normal(random);
      direction[static_cast<std::size_t>(b)][axis] = normal(random);
    }
  }
  const auto target = target_of({1.0, 0.7, 1.3});
  for (const CellEnergy& energy :
       {CellEnergy{0.2, 0.3, 1}, CellEnergy{0.2, 0.0, 2}, CellEnergy{0.5, 0.1, 3}}) {
    ASSERT_GT(CellEnergies(one_cell, target, 8).least_determinant(corner), 0.0);
    std::vector<Vector3d> gradient(8, Vector3d::Zero()), unused(8, Vector3d::Zero());
    const double value = energy_of(energy, target, corner, gradient);
    double slope = 0.0;
    for (std::size_t b = 0; b < 8; ++b) slope += gradient[b].dot(direction[b]);
    // The remainder of Taylor's first order falls by four where the step is halved.
    const auto remainder = [&](double step) {
      std::vector<Vector3d> moved = corner;
      for (std::size_t b = 0; b < 8; ++b) moved[b] += step * direction[b];
      return std::abs(energy_of(energy, target, moved, unused) - value - step * slope);
    };
    EXPECT_NEAR(std::log2(remainder(1e-3) / remainder(5e-4)), 2.0, 0.05);
  }
}

TEST(CellEnergy, IsInfiniteForInvertedCellsUnlessEpsilonIsGiven) {
  std::vector<Vector3d> corner = box(Vector3d::Ones());
  corner[0] = Vector3d(1.2, 1.2, 1.2);
  const auto target = target_of(Vector3d::Ones());
  EXPECT_LT(CellEnergies(one_cell, target, 8).least_determinant(corner), 0.0);
  std::vector<Vector3d> gradient(8, Vector3d::Zero());
  EXPECT_TRUE(std::isinf(energy_of({0.2, 0.0, 1}, target, corner, gradient)));
  EXPECT_TRUE(std::isfinite(energy_of({0.2, 0.1, 1}, target, corner, gradient)));
}

}  // namespace
}  // namespace kappamu::forward
