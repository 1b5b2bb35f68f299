#include "forward/boundary_integral/summation/equivalent_surface.h"

#include "core/numbers/linear_algebra.h"
#include "forward/boundary_integral/summation/point_kernel.h"

namespace kappamu::forward::boundary_integral {

namespace {

/// Pivots below this, of the largest, carry nothing that reaches beyond the next box.
constexpr double least_pivot = 1e-12;

constexpr std::array<std::array<int, 3>, 6> axis_orders{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// G between two lattices, the second's at an offset: (targets, sources).
Eigen::MatrixXd kernel(const Eigen::MatrixX3d& targets, const Eigen::MatrixX3d& sources,
                       const Eigen::Vector3d& offset, double decay) {
  Eigen::MatrixXd result(targets.rows(), sources.rows());
  for (Eigen::Index s = 0; s < sources.rows(); ++s) {
    const Eigen::Vector3d at = sources.row(s).transpose() + offset;
    const Eigen::ArrayXd r = (targets.rowwise() - at.transpose()).rowwise().norm().array();
    result.col(s) = greens_function(r, decay).matrix();
  }
  return result;
}

}  // namespace

SurfaceLattice::SurfaceLattice(int order) : order_(order) {
  for (int k = 0; k < order; ++k) {
    for (int j = 0; j < order; ++j) {
      for (int i = 0; i < order; ++i) {
        const auto side = [&](int n) { return n == 0 || n == order - 1; };
        if (side(i) || side(j) || side(k)) index_.push_back({i, j, k});
      }
    }
  }
}

Eigen::MatrixX3d SurfaceLattice::points(double half) const {
  Eigen::MatrixX3d result(size(), 3);
  for (int n = 0; n < size(); ++n) {
    const auto& [i, j, k] = index_[static_cast<std::size_t>(n)];
    result.row(n) =
        half * (2.0 / (order_ - 1) * Eigen::RowVector3d(i, j, k) - Eigen::RowVector3d::Ones());
  }
  return result;
}

std::vector<int> SurfaceLattice::moved(int flips, const std::array<int, 3>& order) const {
  std::map<std::array<int, 3>, int> number;
  for (int n = 0; n < size(); ++n) number[index_[static_cast<std::size_t>(n)]] = n;
  std::vector<int> result;
  for (std::array<int, 3> at : index_) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (flips >> axis & 1) at[axis] = order_ - 1 - at[axis];
    }
    result.push_back(
        number.at({at[static_cast<std::size_t>(order[0])], at[static_cast<std::size_t>(order[1])],
                   at[static_cast<std::size_t>(order[2])]}));
  }
  return result;
}

EquivalentSurfaces::EquivalentSurfaces(int order, double decay) : lattice_(order), decay_(decay) {
  for (const auto& axes : axis_orders) {
    for (int flips = 0; flips < 8; ++flips) symmetries_.push_back(lattice_.moved(flips, axes));
  }
}

Translation EquivalentSurfaces::translation(const std::array<int, 3>& offset) {
  int flips = 0;
  std::array<int, 3> size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size[axis] = std::abs(offset[axis]);
    if (offset[axis] < 0) flips |= 1 << axis;
  }
  for (std::size_t o = 0; o < axis_orders.size(); ++o) {
    const int x = size[static_cast<std::size_t>(axis_orders[o][0])];
    const int y = size[static_cast<std::size_t>(axis_orders[o][1])];
    const int z = size[static_cast<std::size_t>(axis_orders[o][2])];
    if (x >= y && y >= z) return {16 * x + 4 * y + z, static_cast<int>(8 * o) + flips};
  }
  return {};
}

LevelMaps EquivalentSurfaces::maps(double width) const {
  LevelMaps maps;
  const Eigen::MatrixX3d inner = lattice_.points(0.5 * inner_cube * width);
  const Eigen::MatrixX3d outer = lattice_.points(0.5 * outer_cube * width);
  const Eigen::Vector3d here = Eigen::Vector3d::Zero();
  maps.charges_from_check = pseudo_inverse(kernel(outer, inner, here, decay_), least_pivot);
  const Eigen::MatrixX3d child = lattice_.points(0.25 * inner_cube * width);
  for (int o = 0; o < 8; ++o) {
    const Eigen::Vector3d middle =
        width * Eigen::Vector3d((o & 1) - 0.5, (o >> 1 & 1) - 0.5, (o >> 2 & 1) - 0.5) / 2.0;
    maps.parent_from_child[static_cast<std::size_t>(o)] =
        maps.charges_from_check * kernel(outer, child, middle, decay_);
  }
  for (int x = 2; x <= 3; ++x) {
    for (int y = 0; y <= x; ++y) {
      for (int z = 0; z <= y; ++z) {
        // The source's box lies at −offset from the target's.
        maps.translation[16 * x + 4 * y + z] =
            kernel(inner, inner, -width * Eigen::Vector3d(x, y, z), decay_);
      }
    }
  }
  return maps;
}

}  // namespace kappamu::forward::boundary_integral
