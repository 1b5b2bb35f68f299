#include "inverse/regulariser/roughness.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "core/numbers/widest.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

using Vector = std::vector<double>;

/// Calls pairs(begin, end, neighbour) for the voxels [begin, end) of a row along x that have a
/// neighbour so many voxels away, for each of the six; both of them inside.
template <class Pairs>
void for_neighbours(const MediumSpace& space, int row, const Pairs& pairs) {
  const GridShape& shape = space.shape;
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(shape.nx) * shape.ny;
  const std::size_t first = static_cast<std::size_t>(row) * shape.nx;
  const auto from = [&](int begin, int end, std::ptrdiff_t neighbour) {
    if (space.fraction.empty()) return pairs(begin, end, neighbour);
    const auto inside = [&](int x) {
      return space.inside(first + x) && space.inside(first + x + neighbour);
    };
    for (int x = begin; x < end; ++x) {
      const int here = x;
      while (x < end && inside(x)) ++x;
      if (x > here) pairs(here, x, neighbour);
    }
  };
  from(1, shape.nx, -1);
  from(0, shape.nx - 1, 1);
  if (row % shape.ny > 0) from(0, shape.nx, -shape.nx);
  if (row % shape.ny + 1 < shape.ny) from(0, shape.nx, shape.nx);
  if (row / shape.ny > 0) from(0, shape.nx, -plane);
  if (row / shape.ny + 1 < shape.nz) from(0, shape.nx, plane);
}

/// to[x] += u[x] − u[x + neighbour].
KAPPAMU_WIDEST void add_steps(const double* u, std::ptrdiff_t neighbour, int begin, int end,
                              double* to) {
  for (int x = begin; x < end; ++x) to[x] += u[x] - u[x + neighbour];
}

/// The same times the mean of both voxels' diffusivity d.
KAPPAMU_WIDEST void add_flows(const double* u, const double* d, std::ptrdiff_t neighbour, int begin,
                              int end, double* to) {
  for (int x = begin; x < end; ++x) {
    to[x] += 0.5 * (d[x] + d[x + neighbour]) * (u[x] - u[x + neighbour]);
  }
}

/// Half the squares of the differences, times `share`.
KAPPAMU_WIDEST void add_squares(const double* u, double share, std::ptrdiff_t neighbour, int begin,
                                int end, double* to) {
  for (int x = begin; x < end; ++x) {
    const double step = u[x] - u[x + neighbour];
    to[x] += 0.5 * share * step * step;
  }
}

/// ψ h² and ψ'(s)/s of each voxel of a row, of its |∇v|² h²; `step` = δ per voxel edge.
KAPPAMU_WIDEST void huber(double step, int count, double* square, double* ratio) {
  for (int x = 0; x < count; ++x) {
    const double steep = std::sqrt(square[x]);
    const double most = std::max(steep, step), least = std::min(steep, step);
    square[x] = least * (steep - 0.5 * least);
    ratio[x] = step / most;
  }
}

/// The part of R that belongs to one coefficient: Σ_faces ½ scale (u_i − u_j)² and Σ_voxels
/// ½ pull (u − to)².
struct Part {
  double scale = 0.0;
  double to = 0.0;
  double pull = 0.0;
};

/// Sets the gradient of a part, each face's differences weighed by the mean of both voxels'
/// diffusivity (empty: 1), and each voxel's pull by its share inside. Rows along x are spread over
/// the cores, every voxel gathering from its neighbours. Returns the part's value, where
/// diffusivity is empty with its differences.
double set_gradient(const MediumSpace& space, const Part& part, const std::vector<double>& u,
                    const std::vector<double>& diffusivity, std::vector<double>& gradient) {
  const GridShape& shape = space.shape;
  const auto nx = static_cast<std::size_t>(shape.nx);
  std::vector<double> sums(static_cast<std::size_t>(shape.ny) * shape.nz);
  for_rows(shape.ny * shape.nz, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * nx;
    const double* const here = u.data() + first;
    std::vector<double> slope(nx, 0.0);
    for_neighbours(space, row, [&](int begin, int end, std::ptrdiff_t neighbour) {
      if (diffusivity.empty()) {
        add_steps(here, neighbour, begin, end, slope.data());
      } else {
        add_flows(here, diffusivity.data() + first, neighbour, begin, end, slope.data());
      }
    });
    double even = 0.0, pulled = 0.0;
    for (std::size_t x = 0; x < nx; ++x) {
      const double share = space.fraction.empty() ? 1.0 : space.fraction[first + x];
      const double off = here[x] - part.to, pull = share * part.pull * off;
      gradient[first + x] = part.scale * slope[x] + pull;
      pulled += 0.5 * pull * off;
      // A quadratic form is half its argument times its gradient; no constant changes it.
      if (diffusivity.empty()) even += 0.5 * (here[x] - u[0]) * slope[x];
    }
    sums[static_cast<std::size_t>(row)] = part.scale * even + pulled;
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// Σ_voxels ψ(|∇v|) h², v = (log κ, (log μ)/3), `step` = δ per voxel edge; sets each voxel's
/// ψ'(s)/s.
double huber_sum(const MediumSpace& space, double step, const CoefficientPair& fields,
                 std::vector<double>& diffusivity) {
  const GridShape& shape = space.shape;
  const auto nx = static_cast<std::size_t>(shape.nx);
  diffusivity.resize(shape.cells());
  std::vector<double> sums(static_cast<std::size_t>(shape.ny) * shape.nz);
  for_rows(shape.ny * shape.nz, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * nx;
    std::vector<double> square(nx, 0.0);
    for_neighbours(space, row, [&](int begin, int end, std::ptrdiff_t neighbour) {
      add_squares(fields.log_kappa.data() + first, 1.0, neighbour, begin, end, square.data());
      add_squares(fields.log_mu.data() + first, 1.0 / (absorbers_vary * absorbers_vary), neighbour,
                  begin, end, square.data());
    });
    huber(step, shape.nx, square.data(), diffusivity.data() + first);
    sums[static_cast<std::size_t>(row)] = std::accumulate(square.begin(), square.end(), 0.0);
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// ½ scale Σ_voxels |∇κ|² as a function of log κ.
Roughness wang2008_roughness(const MediumSpace& space, const CoefficientPair& fields,
                             double scale) {
  const std::size_t cells = space.cells();
  Roughness result{0.0, {Vector(cells), Vector(cells, 0.0)}, {}};
  const Vector kappa = exponential(fields.log_kappa);
  const double per_square = scale / (space.shape.voxel_mm * space.shape.voxel_mm);
  result.value = set_gradient(space, {per_square}, kappa, {}, result.gradient.log_kappa);
  for (std::size_t i = 0; i < cells; ++i) result.gradient.log_kappa[i] *= kappa[i];
  return result;
}

}  // namespace

double anchor_scale(const MediumSpace& space, double scale, double length_mm) {
  return scale * std::pow(space.shape.voxel_mm / length_mm, 2);
}

Roughness roughness(const MediumSpace& space, const CoefficientPair& fields,
                    const std::optional<Anchor>& anchor, const Regulariser& regulariser,
                    Roughness storage) {
  if (regulariser.kind == RegulariserKind::wang2008) {
    return wang2008_roughness(space, fields, regulariser.scale);
  }
  Roughness result = std::move(storage);
  result.value = 0.0;
  const double scale = space.shape.voxel_mm / space.thickness_mm;
  if (regulariser.kind == RegulariserKind::huber_tv) {
    result.value =
        scale * huber_sum(space, regulariser.edge_slope * scale, fields, result.diffusivity);
  } else {
    result.diffusivity.clear();
  }
  const auto add = [&](const Vector& u, Vector& gradient, double to, double vary) {
    const double share = scale / (vary * vary);
    const double pull = anchor ? anchor_scale(space, share, anchor->length_mm) : 0.0;
    gradient.resize(space.cells());
    // The gradient of Huber-TV is that of the quadratic form which touches it here.
    result.value += set_gradient(space, {share, to, pull}, u, result.diffusivity, gradient);
  };
  const Anchor to = anchor.value_or(Anchor{});
  add(fields.log_kappa, result.gradient.log_kappa, to.log_kappa, 1.0);
  add(fields.log_mu, result.gradient.log_mu, to.log_mu, absorbers_vary);
  return result;
}

CoefficientPair smoothing_product(const MediumSpace& space, double anchor_length_mm,
                                  const std::vector<double>& diffusivity,
                                  const CoefficientPair& change) {
  CoefficientPair product{Vector(space.cells()), Vector(space.cells())};
  const auto set = [&](const Vector& u, Vector& result, double vary) {
    const double scale = space.shape.voxel_mm / space.thickness_mm / (vary * vary);
    set_gradient(space, {scale, 0.0, anchor_scale(space, scale, anchor_length_mm)}, u, diffusivity,
                 result);
  };
  set(change.log_kappa, product.log_kappa, 1.0);
  set(change.log_mu, product.log_mu, absorbers_vary);
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
