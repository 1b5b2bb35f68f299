#include "inverse/uncertainty/local_information.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace kappamu::inverse {

namespace {

constexpr double pooling = 1.5;  ///< deviation of the Gaussian mean [voxels]

/// Gaussian mean along one axis, normalised to what lies inside the block.
void smooth(Vector& values, const GridShape& shape, int axis) {
  constexpr int reach = 4;
  std::array<double, reach + 1> kernel{};
  for (int k = 0; k <= reach; ++k)
    kernel[static_cast<std::size_t>(k)] = std::exp(-0.5 * std::pow(k / pooling, 2));
  const Vector before = values;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        std::array at{x, y, z};
        const int middle = at[static_cast<std::size_t>(axis)];
        double sum = 0.0;
        double norm = 0.0;
        for (int k = std::max(-reach, -middle);
             k <= std::min(reach, shape.extent(axis) - 1 - middle); ++k) {
          at[static_cast<std::size_t>(axis)] = middle + k;
          sum += kernel[static_cast<std::size_t>(std::abs(k))] *
                 before[shape.index(at[0], at[1], at[2])];
          norm += kernel[static_cast<std::size_t>(std::abs(k))];
        }
        values[shape.index(x, y, z)] = sum / norm;
      }
    }
  }
}

void share_out(Vector& variance, const Vector& beforehand, Vector information,
               const GridShape& shape, int depth_axis) {
  for (double& value : information) value *= value;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != depth_axis) smooth(information, shape, axis);
  }
  const auto depth = static_cast<std::size_t>(shape.extent(depth_axis));
  Vector mean(depth, 0.0);
  const auto each = [&](const auto& visit) {
    for (int z = 0; z < shape.nz; ++z) {
      for (int y = 0; y < shape.ny; ++y) {
        for (int x = 0; x < shape.nx; ++x) {
          visit(shape.index(x, y, z), static_cast<std::size_t>(std::array{
                                          x, y, z}[static_cast<std::size_t>(depth_axis)]));
        }
      }
    }
  };
  const double share = static_cast<double>(depth) / static_cast<double>(shape.cells());
  each([&](std::size_t i, std::size_t layer) { mean[layer] += share * information[i]; });
  each([&](std::size_t i, std::size_t layer) {
    if (mean[layer] <= 0.0) return;
    const double gained = std::max(0.0, 1.0 / variance[i] - 1.0 / beforehand[i]);
    variance[i] = 1.0 / (1.0 / beforehand[i] + gained * information[i] / mean[layer]);
  });
}

}  // namespace

CoefficientPair shared_out(CoefficientPair variance, const CoefficientPair& beforehand,
                           CoefficientPair sensitivity, const GridShape& shape, int depth_axis) {
  share_out(variance.log_kappa, beforehand.log_kappa, std::move(sensitivity.log_kappa), shape,
            depth_axis);
  share_out(variance.log_mu, beforehand.log_mu, std::move(sensitivity.log_mu), shape, depth_axis);
  return variance;
}

}  // namespace kappamu::inverse
