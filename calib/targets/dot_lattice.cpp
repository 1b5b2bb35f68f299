#include "calib/targets/dot_lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace kappamu::calib {
namespace {

using Eigen::Matrix2i;
using Eigen::Vector2d;
using Eigen::Vector2i;
using Steps = std::array<Vector2d, 2>;  ///< to the next dot along either axis of the lattice
using Place = std::array<int, 2>;
using Lattice = std::map<Place, std::size_t>;  ///< the dot at each place that has one

/// The others, nearest first.
std::vector<std::size_t> neighbours(const std::vector<Vector2d>& dots, std::size_t of,
                                    std::size_t count) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < dots.size(); ++k) {
    if (k != of) order.push_back(k);
  }
  count = std::min(count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return (dots[a] - dots[of]).squaredNorm() <
                             (dots[b] - dots[of]).squaredNorm();
                    });
  order.resize(count);
  return order;
}

/// Dots that can be reached from `seed`.
Lattice follow(const std::vector<Vector2d>& dots, std::size_t seed, const Steps& start) {
  constexpr double tolerance = 0.3;  // of a step; the next dot is a whole one further
  Lattice lattice{{{0, 0}, seed}};
  std::set<std::size_t> used{seed};
  std::vector<std::tuple<Place, std::size_t, Steps>> front{{{0, 0}, seed, start}};
  for (std::size_t at = 0; at < front.size(); ++at) {
    const auto [place, dot, steps] = front[at];
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (const int sense : {-1, 1}) {
        Place next = place;
        next[axis] += sense;
        if (lattice.count(next) != 0) continue;
        const Vector2d expected = dots[dot] + sense * steps[axis];
        const auto nearest = std::min_element(dots.begin(), dots.end(), [&](auto& a, auto& b) {
          return (a - expected).squaredNorm() < (b - expected).squaredNorm();
        });
        const auto found = static_cast<std::size_t>(nearest - dots.begin());
        const double reach = tolerance * std::min(steps[0].norm(), steps[1].norm());
        if ((*nearest - expected).norm() > reach || !used.insert(found).second) continue;
        lattice[next] = found;
        Steps onwards = steps;
        onwards[axis] = sense * (*nearest - dots[dot]);
        front.emplace_back(next, found, onwards);
      }
    }
  }
  return lattice;
}

/// Changes of the lattice's basis that neither mirror it nor leave a dot out.
std::vector<Matrix2i> bases() {
  std::vector<Matrix2i> all;
  for (int k = 0; k < 81; ++k) {
    const Matrix2i m{{k % 3 - 1, k / 3 % 3 - 1}, {k / 9 % 3 - 1, k / 27 - 1}};
    if (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0) == 1) all.push_back(m);
  }
  return all;
}

/// Dot (i, j) in steps of the grid's own lattice, which a staggered grid has along its diagonals.
Vector2i own_place(const DotGrid& grid, int i, int j) {
  if (!grid.staggered) return {i, j};
  const int x = 2 * i + j % 2;
  return {(x + j) / 2, (j - x) / 2};
}

/// All ways to see the grid in the lattice, as dots in rows.
std::vector<std::vector<std::size_t>> ways(const Lattice& lattice, const DotGrid& grid) {
  std::vector<std::vector<std::size_t>> all;
  if (lattice.size() < grid.count()) return all;
  static const std::vector<Matrix2i> changes = bases();
  for (const Matrix2i& change : changes) {
    for (const auto& [origin, first] : lattice) {
      std::vector<std::size_t> dots;
      for (int j = 0; j < grid.rows; ++j) {
        for (int i = 0; i < grid.columns; ++i) {
          const Vector2i at = change * own_place(grid, i, j);
          const auto found = lattice.find({origin[0] + at.x(), origin[1] + at.y()});
          if (found == lattice.end()) break;
          dots.push_back(found->second);
        }
        if (dots.size() != static_cast<std::size_t>(j + 1) * grid.columns) break;
      }
      if (dots.size() == grid.count()) all.push_back(dots);
    }
  }
  return all;
}

/// Cosine between the rows' mean direction and the picture's right.
double uprightness(const std::vector<Vector2d>& dots, const DotGrid& grid,
                   const std::vector<std::size_t>& way) {
  Vector2d along = Vector2d::Zero();
  for (std::size_t first = 0; first < way.size(); first += grid.columns) {
    along += dots[way[first + grid.columns - 1]] - dots[way[first]];
  }
  return along.normalized().x();
}

bool same_dots(std::vector<std::size_t> a, std::vector<std::size_t> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  return a == b;
}

std::optional<DotGrid> grid_of_all(const Lattice& lattice, const DotGrid& wanted) {
  constexpr int fewest = 3;  // across
  const int count = static_cast<int>(lattice.size());
  for (const bool staggered : {wanted.staggered, !wanted.staggered}) {
    // Wide ones first: which of the two it is, only the staggered tell.
    for (int rows = fewest; rows * fewest <= count; ++rows) {
      const DotGrid grid{count / rows, rows, staggered};
      if (grid.columns * rows == count && !ways(lattice, grid).empty()) {
        return wanted.rows > wanted.columns && !wanted.staggered && !staggered
                   ? DotGrid{rows, grid.columns, false}
                   : grid;
      }
    }
  }
  return std::nullopt;
}

}  // namespace

DotSearch find_dot_grid(const std::vector<Vector2d>& dots, const DotGrid& wanted) {
  DotSearch search;
  constexpr std::size_t nearest = 8;  // of any view of a lattice two span it
  std::vector<bool> tried(dots.size(), false);
  for (std::size_t seed = 0; seed < dots.size(); ++seed) {
    if (tried[seed]) continue;
    const std::vector<std::size_t> around = neighbours(dots, seed, nearest);
    for (std::size_t b = 1; b < around.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        Steps steps{dots[around[a]] - dots[seed], dots[around[b]] - dots[seed]};
        const double sine = steps[0].x() * steps[1].y() - steps[0].y() * steps[1].x();
        constexpr double least_sine = 0.3;
        if (std::abs(sine) < least_sine * steps[0].norm() * steps[1].norm()) continue;
        if (sine < 0.0) std::swap(steps[0], steps[1]);
        const Lattice lattice = follow(dots, seed, steps);
        constexpr std::size_t by_chance = 9;
        if (lattice.size() < by_chance) continue;
        for (const auto& [place, dot] : lattice) tried[dot] = true;
        const auto found = ways(lattice, wanted);
        if (found.empty()) {
          const std::optional<DotGrid> other = grid_of_all(lattice, wanted);
          if (other && (!search.other || other->count() > search.other->count())) {
            search.other = other;
          }
          continue;
        }
        const auto best = std::max_element(found.begin(), found.end(), [&](auto& p, auto& q) {
          return uprightness(dots, wanted, p) < uprightness(dots, wanted, q);
        });
        if (!std::all_of(found.begin(), found.end(),
                         [&](const auto& way) { return same_dots(way, *best); })) {
          return {{}, grid_of_all(lattice, wanted)};
        }
        for (const std::size_t dot : *best) search.grid.push_back(dots[dot]);
        return search;
      }
    }
  }
  return search;
}

}  // namespace kappamu::calib
