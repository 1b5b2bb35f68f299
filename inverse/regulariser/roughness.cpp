#include "inverse/regulariser/roughness.h"

#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// Calls from(begin, end, neighbour) for the voxels [begin, end) of a row along x that have a
/// neighbour so many voxels away, for each of the six.
template <class From>
void for_neighbours(const GridShape& shape, int row, const From& from) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(shape.nx) * shape.ny;
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
double differences(const GridShape& shape, double scale, const std::vector<double>& u,
                   const std::vector<double>& diffusivity, std::vector<double>& gradient) {
  std::vector<double> sums(static_cast<std::size_t>(shape.ny) * shape.nz);
  for_rows(shape.ny * shape.nz, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * shape.nx;
    const double* const here = u.data() + first;
    std::vector<double> slope(static_cast<std::size_t>(shape.nx), 0.0);
    const auto from = [&](int begin, int end, std::ptrdiff_t neighbour) {
      if (diffusivity.empty()) {
        for (int x = begin; x < end; ++x) slope[x] += here[x] - here[x + neighbour];
      } else {
        const double* const d = diffusivity.data() + first;
        for (int x = begin; x < end; ++x) {
          slope[x] += 0.5 * (d[x] + d[x + neighbour]) * (here[x] - here[x + neighbour]);
        }
      }
    };
    for_neighbours(shape, row, from);
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
std::vector<double> squared_slopes(const GridShape& shape, int row, const CoefficientPair& fields) {
  std::vector<double> square(static_cast<std::size_t>(shape.nx), 0.0);
  const auto add = [&](const std::vector<double>& u, double share) {
    const double* const here = u.data() + static_cast<std::size_t>(row) * shape.nx;
    for_neighbours(shape, row, [&](int begin, int end, std::ptrdiff_t neighbour) {
      for (int x = begin; x < end; ++x) {
        const double step = here[x] - here[x + neighbour];
        square[x] += 0.5 * share * step * step;
      }
    });
  };
  add(fields.log_kappa, 1.0);
  add(fields.log_mu, 1.0 / (absorbers_vary * absorbers_vary));
  return square;
}

/// Σ_voxels ψ(|∇v|) h², `step` = δ per voxel edge; sets each voxel's ψ'(s)/s.
double huber_sum(const GridShape& shape, double step, const CoefficientPair& fields,
                 std::vector<double>& diffusivity) {
  diffusivity.resize(shape.cells());
  std::vector<double> sums(static_cast<std::size_t>(shape.ny) * shape.nz);
  for_rows(shape.ny * shape.nz, [&](int row) {
    const std::vector<double> square = squared_slopes(shape, row, fields);
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

/// What multiplies ½ (v − v*)² of a voxel.
double anchor_scale(const GridShape& shape, double scale, const Anchor& anchor) {
  return scale * std::pow(shape.voxel_mm / anchor.length_mm, 2);
}

/// Σ_voxels ½ pull (u − to)²; adds its gradient.
double pull_to(double to, double pull, const std::vector<double>& u,
               std::vector<double>& gradient) {
  std::vector<double> sums(pieces(u.size()));
  for_pieces(u.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      sum += 0.5 * pull * (u[i] - to) * (u[i] - to);
      gradient[i] += pull * (u[i] - to);
    }
    sums[piece] = sum;
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// ½ scale Σ_voxels |∇κ|² as a function of log κ.
Roughness wang2008_roughness(const GridShape& shape, const CoefficientPair& fields, double scale) {
  const std::size_t cells = shape.cells();
  Roughness result{0.0, zeros(cells), {}};
  std::vector<double> kappa(cells);
  for (std::size_t i = 0; i < cells; ++i) kappa[i] = std::exp(fields.log_kappa[i]);
  const double per_square = scale / (shape.voxel_mm * shape.voxel_mm);
  result.value = per_square * differences(shape, per_square, kappa, {}, result.gradient.log_kappa);
  for (std::size_t i = 0; i < cells; ++i) result.gradient.log_kappa[i] *= kappa[i];
  return result;
}

}  // namespace

Roughness roughness(const GridShape& shape, double thickness_mm, const CoefficientPair& fields,
                    const std::optional<Anchor>& anchor, const Regulariser& regulariser) {
  if (regulariser.kind == RegulariserKind::wang2008) {
    return wang2008_roughness(shape, fields, regulariser.scale);
  }
  Roughness result{0.0, zeros(shape.cells()), {}};
  const double scale = shape.voxel_mm / thickness_mm;
  const bool huber = regulariser.kind == RegulariserKind::huber_tv;
  if (huber) {
    result.value =
        scale * huber_sum(shape, regulariser.edge_slope * scale, fields, result.diffusivity);
  }
  const auto add = [&](const std::vector<double>& u, std::vector<double>& gradient, double to,
                       double vary) {
    const double share = scale / (vary * vary);
    // The gradient of Huber-TV is that of the quadratic form which touches it here.
    const double even = differences(shape, share, u, result.diffusivity, gradient);
    if (!huber) result.value += share * even;
    if (anchor) result.value += pull_to(to, anchor_scale(shape, share, *anchor), u, gradient);
  };
  const Anchor to = anchor.value_or(Anchor{});
  add(fields.log_kappa, result.gradient.log_kappa, to.log_kappa, 1.0);
  add(fields.log_mu, result.gradient.log_mu, to.log_mu, absorbers_vary);
  return result;
}

CoefficientPair smoothing_product(const GridShape& shape, double thickness_mm,
                                  double anchor_length_mm, const std::vector<double>& diffusivity,
                                  const CoefficientPair& change) {
  CoefficientPair product = zeros(shape.cells());
  const auto add = [&](const std::vector<double>& u, std::vector<double>& result, double vary) {
    const double scale = shape.voxel_mm / thickness_mm / (vary * vary);
    differences(shape, scale, u, diffusivity, result);
    pull_to(0.0, anchor_scale(shape, scale, {0.0, 0.0, anchor_length_mm}), u, result);
  };
  add(change.log_kappa, product.log_kappa, 1.0);
  add(change.log_mu, product.log_mu, absorbers_vary);
  return product;
}

double metric_weight(const Regulariser& regulariser, double weight, const GridShape& shape,
                     double thickness_mm, double kappa) {
  if (regulariser.kind != RegulariserKind::wang2008) return weight;
  // (κ_i − κ_j)²/h² = (κ/h)² (log κ_i − log κ_j)² where κ varies little; H1 has h/ℓ instead.
  const double per_face = regulariser.scale * kappa * kappa / (shape.voxel_mm * shape.voxel_mm);
  return weight * per_face * thickness_mm / shape.voxel_mm;
}

}  // namespace kappamu::inverse
