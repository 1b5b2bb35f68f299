#include "forward/polygrid/beams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "forward/light_entry.h"
#include "forward/polygrid/cell_walk.h"
#include "forward/polygrid/equations/cell_integrals.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

/// Beams are marched in a fixed number of parts, each with its own load: the same bits on any
/// number of cores.
constexpr std::size_t parts = 4;
/// A step over the shortest of a cell's three middle lines.
constexpr double step_of_cell = 0.5;
constexpr int most_steps = 100'000;

/// Shortest distance between the middles of opposite sides.
double width_of(const Polygrid& grid, std::size_t cell) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d across = Vector3d::Zero();
    for (int c = 0; c < 8; ++c) {
      const int corner = grid.cell_corners[cell][static_cast<std::size_t>(c)];
      across +=
          ((c >> axis & 1) != 0 ? 0.25 : -0.25) * grid.corner[static_cast<std::size_t>(corner)];
    }
    shortest = std::min(shortest, across.norm());
  }
  return shortest;
}

struct March {
  const Polygrid& grid;
  std::span<const Coefficients> of_cell;
  double remainder;

  void run(const BeamPath& path, CellPoint at, std::vector<double>& load,
           ObjectBalance& balance) const {
    const double least = remainder * path.power;
    double power = path.power, from = 0.0;
    for (int k = 0; k < most_steps && from < path.length && power > 0.0; ++k) {
      const double step = std::min(step_of_cell * width_of(grid, static_cast<std::size_t>(at.cell)),
                                   path.length - from);
      const auto [kappa, mu] = of_cell[static_cast<std::size_t>(at.cell)];
      const double sigma_t = 1.0 / (3.0 * kappa), depth = sigma_t * step;
      const double left = power * std::exp(-depth);
      const double collided = left > least ? power - left : power;
      // ∫ s e^(−σ s) ds over ∫ e^(−σ s) ds, by its series where the step is thin.
      const double mean = depth < 1e-4 ? 0.5 * step : 1.0 / sigma_t - step / std::expm1(depth);
      at = walk_to(grid, at, path.from + (from + mean) * path.direction);
      const double absorbed = collided * std::min(1.0, mu / sigma_t);
      const std::array<double, 8> n = shape_functions(at.local);
      const auto& corners = grid.cell_corners[static_cast<std::size_t>(at.cell)];
      for (std::size_t c = 0; c < 8; ++c) {
        load[static_cast<std::size_t>(corners[c])] += (collided - absorbed) * n[c];
      }
      balance.absorbed += absorbed;
      power -= collided;
      from += step;
    }
    balance.unscattered += power;
  }
};

}  // namespace

void add_beams(const Polygrid& grid, const SurfaceMap& map, const ObjectProblem& problem,
               const ObjectLight& light, std::span<const Coefficients> of_cell, double remainder,
               std::vector<double>& load, ObjectBalance& balance) {
  const March march{grid, of_cell, remainder};
  const double size = bounding_box(problem.mesh).sizes().maxCoeff();
  std::vector<std::vector<double>> loads(light.beams.empty() ? 0 : parts);
  std::array<ObjectBalance, parts> powers;
  for_rows(static_cast<int>(loads.size()), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    loads[part].assign(load.size(), 0.0);
    const std::size_t count = light.beams.size();
    for (std::size_t k = part * count / parts; k < (part + 1) * count / parts; ++k) {
      const BeamPath path = enter(problem, light.beams[k], size);
      const int side = map.side_of(static_cast<std::size_t>(light.beams[k].triangle));
      const CellPoint start{grid.boundary_cell[static_cast<std::size_t>(side)],
                            Vector3d::Constant(0.5)};
      powers[part].entering += path.power;
      march.run(path, walk_to(grid, start, path.from), loads[part], powers[part]);
    }
  });
  for (std::size_t part = 0; part < loads.size(); ++part) {
    balance.entering += powers[part].entering;
    balance.absorbed += powers[part].absorbed;
    balance.unscattered += powers[part].unscattered;
    for (std::size_t i = 0; i < load.size(); ++i) load[i] += loads[part][i];
  }
}

}  // namespace kappamu::forward::polygrid
