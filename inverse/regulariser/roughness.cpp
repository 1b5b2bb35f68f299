#include "inverse/regulariser/roughness.h"

#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// Calls pair(x, neighbour) for the voxels of a row along x that have a neighbour so many voxels
/// away, for each of the six; both of them inside.
template <class Pair>
void for_neighbours(const MediumSpace& space, int row, const Pair& pair) {
  const GridShape& shape = space.shape;
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(shape.nx) * shape.ny;
  const std::size_t first = static_cast<std::size_t>(row) * shape.nx;
  const auto from = [&](int begin, int end, std::ptrdiff_t neighbour) {
    if (space.fraction.empty()) {
      for (int x = begin; x < end; ++x) pair(x, neighbour);
      return;
    }
    for (int x = begin; x < end; ++x) {
      if (space.inside(first + x) && space.inside(first + x + neighbour)) pair(x, neighbour);
    }
  };
  from(1, shape.nx, -1);
  from(0, shape.nx - 1, 1);
  if (row % shape.ny > 0) from(0, shape.nx, -shape.nx);
  if (row % shape.ny + 1 < shape.ny) from(0, shape.nx, shape.nx);
  if (row / shape.ny > 0) from(0, shape.nx, -plane);
  if (row / shape.ny + 1 < shape.nz) from(0, shape.nx, plane);
}

/// Σ_faces ½ d (u_i − u_j)², d the mean of both voxels' diffusivity (empty: 1); adds `scale` times
/// its gradient at constant d. Rows along x are spread over the cores, every voxel gathering from
/// its neighbours.
double differences(const MediumSpace& space, double scale, const std::vector<double>& u,
                   const std::vector<double>& diffusivity, std::vector<double>& gradient) {
  const GridShape& shape = space.shape;
  std::vector<double> sums(static_cast<std::size_t>(shape.ny) * shape.nz);
  for_rows(shape.ny * shape.nz, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * shape.nx;
    const double* const here = u.data() + first;
    std::vector<double> slope(static_cast<std::size_t>(shape.nx), 0.0);
    if (diffusivity.empty()) {
      for_neighbours(space, row, [&](int x, std::ptrdiff_t neighbour) {
        slope[x] += here[x] - here[x + neighbour];
      });
    } else {
      const double* const d = diffusivity.data() + first;
      for_neighbours(space, row, [&](int x, std::ptrdiff_t neighbour) {
        slope[x] += 0.5 * (d[x] + d[x + neighbour]) * (here[x] - here[x + neighbour]);
      });
    }
    // A quadratic form is half its argument times its gradient; no constant changes it.
    double sum = 0.0;
    for (int x = 0; x < shape.nx; ++x) {
      gradient[first + x] += scale * slope[x];
      sum += 0.5 * (here[x] - u[0]) * slope[x];
    }
    sums[row] = sum;
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// |∇v|² h² of each voxel of a row, v = (log κ, (log μ)/3).
std::vector<double> squared_slopes(const MediumSpace& space, int row,
                                   const CoefficientPair& fields) {
  const GridShape& shape = space.shape;
  std::vector<double> square(static_cast<std::size_t>(shape.nx), 0.0);
  const auto add = [&](const std::vector<double>& u, double share) {
    const double* const here = u.data() + static_cast<std::size_t>(row) * shape.nx;
    for_neighbours(space, row, [&](int x, std::ptrdiff_t neighbour) {
      const double step = here[x] - here[x + neighbour];
      square[x] += 0.5 * share * step * step;
    });
  };
  add(fields.log_kappa, 1.0);
  add(fields.log_mu, 1.0 / (absorbers_vary * absorbers_vary));
  return square;
}

/// Σ_voxels ψ(|∇v|) h², `step` = δ per voxel edge; sets each voxel's ψ'(s)/s.
double huber_sum(const MediumSpace& space, double step, const CoefficientPair& fields,
                 std::vector<double>& diffusivity) {
  const GridShape& shape = space.shape;
  diffusivity.resize(shape.cells());
  std::vector<double> sums(static_cast<std::size_t>(shape.ny) * shape.nz);
  for_rows(shape.ny * shape.nz, [&](int row) {
    const std::vector<double> square = squared_slopes(space, row, fields);
    double* const ratio = diffusivity.data() + static_cast<std::size_t>(row) * shape.nx;
    double sum = 0.0;
    for (int x = 0; x < shape.nx; ++x) {
      const double steep = std::sqrt(square[x]);
      const bool edge = steep > step;
      sum += edge ? step * (steep - 0.5 * step) : 0.5 * square[x];
      ratio[x] = edge ? step / steep : 1.0;
    }
    sums[row] = sum;
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

CoefficientPair zeros(std::size_t cells) {
  return {std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)};
}

/// Factor on ½ (v − v*)² of a voxel.
double anchor_scale(const MediumSpace& space, double scale, const Anchor& anchor) {
  return scale * std::pow(space.shape.voxel_mm / anchor.length_mm, 2);
}

/// Σ_voxels ½ pull (u − to)² by their shares inside; adds its gradient.
double pull_to(const MediumSpace& space, double to, double pull, const std::vector<double>& u,
               std::vector<double>& gradient) {
  std::vector<double> sums(pieces(u.size()));
  for_pieces(u.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double here = space.fraction.empty() ? pull : pull * space.fraction[i];
      sum += 0.5 * here * (u[i] - to) * (u[i] - to);
      gradient[i] += here * (u[i] - to);
    }
    sums[piece] = sum;
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// ½ scale Σ_voxels |∇κ|² as a function of log κ.
Roughness wang2008_roughness(const MediumSpace& space, const CoefficientPair& fields,
                             double scale) {
  const std::size_t cells = space.cells();
  Roughness result{0.0, zeros(cells), {}};
  std::vector<double> kappa(cells);
  for (std::size_t i = 0; i < cells; ++i) kappa[i] = std::exp(fields.log_kappa[i]);
  const double per_square = scale / (space.shape.voxel_mm * space.shape.voxel_mm);
  result.value = per_square * differences(space, per_square, kappa, {}, result.gradient.log_kappa);
  for (std::size_t i = 0; i < cells; ++i) result.gradient.log_kappa[i] *= kappa[i];
  return result;
}

}  // namespace

Roughness roughness(const MediumSpace& space, const CoefficientPair& fields,
                    const std::optional<Anchor>& anchor, const Regulariser& regulariser) {
  if (regulariser.kind == RegulariserKind::wang2008) {
    return wang2008_roughness(space, fields, regulariser.scale);
  }
  Roughness result{0.0, zeros(space.cells()), {}};
  const double scale = space.shape.voxel_mm / space.thickness_mm;
  const bool huber = regulariser.kind == RegulariserKind::huber_tv;
  if (huber) {
    result.value =
        scale * huber_sum(space, regulariser.edge_slope * scale, fields, result.diffusivity);
  }
  const auto add = [&](const std::vector<double>& u, std::vector<double>& gradient, double to,
                       double vary) {
    const double share = scale / (vary * vary);
    // The gradient of Huber-TV is that of the quadratic form which touches it here.
    const double even = differences(space, share, u, result.diffusivity, gradient);
    if (!huber) result.value += share * even;
    if (anchor)
      result.value += pull_to(space, to, anchor_scale(space, share, *anchor), u, gradient);
  };
  const Anchor to = anchor.value_or(Anchor{});
  add(fields.log_kappa, result.gradient.log_kappa, to.log_kappa, 1.0);
  add(fields.log_mu, result.gradient.log_mu, to.log_mu, absorbers_vary);
  return result;
}

CoefficientPair smoothing_product(const MediumSpace& space, double anchor_length_mm,
                                  const std::vector<double>& diffusivity,
                                  const CoefficientPair& change) {
  CoefficientPair product = zeros(space.cells());
  const auto add = [&](const std::vector<double>& u, std::vector<double>& result, double vary) {
    const double scale = space.shape.voxel_mm / space.thickness_mm / (vary * vary);
    differences(space, scale, u, diffusivity, result);
    pull_to(space, 0.0, anchor_scale(space, scale, {0.0, 0.0, anchor_length_mm}), u, result);
  };
  add(change.log_kappa, product.log_kappa, 1.0);
  add(change.log_mu, product.log_mu, absorbers_vary);
  return product;
}

double metric_weight(const Regulariser& regulariser, double weight, const MediumSpace& space,
                     double kappa) {
  if (regulariser.kind != RegulariserKind::wang2008) return weight;
  // (κ_i − κ_j)²/h² = (κ/h)² (log κ_i − log κ_j)² where κ varies little; H1 has h/ℓ instead.
  const double h = space.shape.voxel_mm;
  const double per_face = regulariser.scale * kappa * kappa / (h * h);
  return weight * per_face * space.thickness_mm / h;
}

}  // namespace kappamu::inverse
