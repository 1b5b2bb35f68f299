#include "forward/embedded/equations/row_levels.h"

namespace kappamu::forward::embedded {

namespace {

using linear::Lanes;
using linear::RowLevel;
using linear::RowLevels;
using linear::RowMatrix;
using linear::RowSum;

/// The finest levels, on which equations are solved.
constexpr std::size_t solved_levels = 2;

/// Of 2, 3 and 5 the last takes the least time on thin and jagged objects, and half the
/// iterations of 2. On levels of few unknowns, which cost little, twice as many steps halve the
/// iterations of spikes far thinner than a cube.
constexpr int smoothing_degree(std::size_t unknowns) {
  constexpr std::size_t few = 8000;
  return unknowns <= few ? 10 : 5;
}

RowMatrix<double> assembled(const NodeSpace& space, const Elements& elements, const Lanes& lanes) {
  const Incidence incidence(space);
  const std::size_t used = lanes.channels.size();
  const auto fill = [&](std::size_t u, RowSum& row) {
    for (int k = incidence.start[u]; k < incidence.start[u + 1]; ++k) {
      const auto slot = static_cast<std::size_t>(incidence.slot[static_cast<std::size_t>(k)]);
      const std::size_t cube = slot / 8, i = slot % 8;
      const double weight = NodeSpace::weight(space.parts(cube, i));
      for (std::size_t j = 0; j < 8; ++j) {
        const auto parts = space.parts(cube, j);
        const double both = weight * NodeSpace::weight(parts);
        for (const int column : parts) {
          double* values = row.at(column);
          for (std::size_t m = 0; m < used; ++m) {
            values[m] += both * elements.of(cube, lanes.channels[m])(i, j);
          }
        }
      }
    }
  };
  return linear::make_rows(space.unknowns(), space.unknowns(), lanes.media(), fill);
}

/// Values of coarse functions at the fine unknowns.
RowMatrix<float> interpolation(const NodeSpace& fine, const NodeSpace& coarse,
                               const Coarser& coarser) {
  const std::vector<int> owner = owner_slots(fine);
  const auto fill = [&](std::size_t u, RowSum& row) {
    for_coarser_parts(coarser, coarse, owner[u],
                      [&](int column, double weight) { *row.at(column) += weight; });
  };
  return linear::make_rows(fine.unknowns(), coarse.unknowns(), 1, fill).rounded<float>();
}

}  // namespace

RowLevels make_row_levels(const Levels& levels, const Lanes& lanes) {
  RowLevels result;
  for (std::size_t l = 0; l < levels.level.size(); ++l) {
    const Level& from = levels.level[l];
    RowLevel& level = result.level.emplace_back();
    level.rows = from.space.unknowns();
    level.smoothing_degree = smoothing_degree(level.rows);
    const bool coarsest = l + 1 == levels.level.size();
    if (coarsest && l >= solved_levels) break;
    level.equations = assembled(from.space, from.elements, lanes);
    if (!coarsest) {
      level.matrix = level.equations.rounded<float>();
      level.inverse_scale = linear::by_medium(level.rows, lanes, [&](std::size_t m, std::size_t u) {
        return from.inverse_scale[lanes.channels[m]][u];
      });
      const NodeSpace& coarse = levels.level[l + 1].space;
      level.interpolation = interpolation(from.space, coarse, from.coarser);
      level.restriction = linear::transposed(level.interpolation, coarse.unknowns());
    }
    if (l >= solved_levels) level.equations = {};
  }
  const std::size_t size = result.level.back().rows;
  result.coarsest = linear::by_medium(size * size, lanes, [&](std::size_t m, std::size_t k) {
    return levels.coarsest[lanes.channels[m]].data()[k];  // symmetric
  });
  return result;
}

}  // namespace kappamu::forward::embedded
