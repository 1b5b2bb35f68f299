// What every level keeps against its definition, cell by cell in double from what it is made of:
// weights and coarse conductances (grid_coarsen.cl), sums and smoother (grid_assemble.cl).
// Conductances of the finest level are not tested here but by equivalence_test.cpp.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "device/context.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"
#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Values;
using Cell = std::array<int, 3>;

/// A level's arrays in double; cells outside the block are asked for as such.
struct Arrays {
  GridShape shape;
  Cell halving{};
  std::array<Values, 3> g, w;
  Values sink, inverse, smoother;

  std::size_t at(const Cell& c) const { return shape.index(c[0], c[1], c[2]); }
  bool inside(const Cell& c, int axis) const {
    return c[static_cast<std::size_t>(axis)] >= 0 &&
           c[static_cast<std::size_t>(axis)] < shape.extent(axis);
  }
  /// Face between `c` and its neighbour across `axis`, the upper (1) or lower (0).
  double& face_at(int axis, Cell c, int up) {
    const auto a = static_cast<std::size_t>(axis);
    c[a] += up;
    GridShape faces = shape;
    (axis == 0 ? faces.nx : axis == 1 ? faces.ny : faces.nz) += 1;
    return g[a][faces.index(c[0], c[1], c[2])];
  }
  double face(int axis, const Cell& c, int up) const {
    return const_cast<Arrays*>(this)->face_at(axis, c, up);
  }
  double weight(int axis, const Cell& c) const { return w[static_cast<std::size_t>(axis)][at(c)]; }
  double loose(const Cell& c) const { return std::pow(inverse[at(c)], 0.625); }
};

Cell step(Cell c, int axis, int up) {
  c[static_cast<std::size_t>(axis)] += up != 0 ? 1 : -1;
  return c;
}

/// Towards the sibling of c: 1 where it is above.
int to_sibling(const Cell& c, int axis) {
  return c[static_cast<std::size_t>(axis)] % 2 == 0 ? 1 : 0;
}

/// Resistance between cell c and the node of its coarse cell.
double to_node(const Arrays& l, const Cell& c, int axis) {
  const int up = to_sibling(c, axis);
  const Cell sibling = step(c, axis, up);
  if (!l.inside(c, axis) || !l.inside(sibling, axis)) return 0.0;
  return l.loose(c) / ((l.loose(c) + l.loose(sibling)) * l.face(axis, c, up));
}

double expected_weight(const Arrays& l, const Cell& c, int axis) {
  if (l.halving[static_cast<std::size_t>(axis)] == 0) return 0.0;
  const int away = 1 - to_sibling(c, axis);
  const double g = l.face(axis, c, away), here = to_node(l, c, axis);
  return g > 0.0 ? here / (here + 1.0 / g + to_node(l, step(c, axis, away), axis)) : 0.0;
}

/// Energy of a step of 1 that cell c beside it costs: against its sibling and its neighbours
/// across.
double energy_beside(const Arrays& l, const Cell& c, int axis) {
  double energy = 0.0;
  const double w = l.weight(axis, c);
  const int up = to_sibling(c, axis);
  const Cell sibling = step(c, axis, up);
  if (l.inside(sibling, axis)) {
    const bool coarse_beyond = l.inside(step(sibling, axis, up), axis);
    energy += l.face(axis, c, up) * w * (w + (coarse_beyond ? l.weight(axis, sibling) : 0.0));
  }
  for (int other = 0; other < 3; ++other) {
    for (int side = 0; side < 2; ++side) {
      const Cell k = step(c, other, side);
      if (other == axis || !l.inside(k, other)) continue;
      energy += 0.15 * l.face(other, c, side) * std::pow(w - l.weight(axis, k), 2);
    }
  }
  return energy;
}

/// What the face under cell j across `axis` adds to its coarse face.
double expected_conductance(const Arrays& l, const Cell& j, int axis) {
  const Cell i = step(j, axis, 0);
  const bool surface = !l.inside(i, axis) || !l.inside(j, axis);
  const double g = l.inside(j, axis) ? l.face(axis, j, 0) : l.face(axis, i, 1);
  if (l.halving[static_cast<std::size_t>(axis)] == 0) return g;
  if (surface) return g > 0.0 ? 1.0 / (1.0 / g + to_node(l, i, axis) + to_node(l, j, axis)) : 0.0;
  return g * std::pow(1.0 - l.weight(axis, i) - l.weight(axis, j), 2) + energy_beside(l, i, axis) +
         energy_beside(l, j, axis);
}

/// ω / S_ii on red cells, 1 / D on black ones.
double expected_smoother(const Arrays& l, const Cell& c) {
  if ((c[0] + c[1] + c[2]) % 2 != 0) return l.inverse[l.at(c)];
  double diagonal = l.sink[l.at(c)];
  for (int axis = 0; axis < 3; ++axis) {
    for (int up = 0; up < 2; ++up) {
      const Cell k = step(c, axis, up);
      double share = 1.0;
      if (l.inside(k, axis)) {
        share = l.sink[l.at(k)];
        for (int face = 0; face < 6; ++face) {
          if (face != 2 * axis + 1 - up) share += l.face(face / 2, k, face % 2);
        }
        share *= l.inverse[l.at(k)];
      }
      diagonal += l.face(axis, c, up) * share;
    }
  }
  return 5.0 / 6.0 / diagonal;
}

template <class F>
void each(const GridShape& s, F f) {
  for (int z = 0; z < s.nz; ++z) {
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) f(Cell{x, y, z});
    }
  }
}

class GridLevels : public testing::OnBackend {
 protected:
  static device::Context& context() { return device::Context::chosen(GetParam().device); }
  static Values values(const device::Buffer& buffer) {
    const std::size_t count = buffer.bytes() / (single() ? sizeof(float) : sizeof(double));
    if (!single()) {
      Values all(count);
      context().read(buffer, all.data(), buffer.bytes());
      return all;
    }
    std::vector<float> all(count);
    context().read(buffer, all.data(), buffer.bytes());
    return {all.begin(), all.end()};
  }
  static void set_medium(Hierarchy& hierarchy, const Values& kappa, const Values& mu) {
    const Format format{single(), true};
    hierarchy.set_medium(uploaded(context(), format, kappa), uploaded(context(), format, mu));
  }
  /// Of what a solve reads of a level: faces, sink and smoother of each cell.
  static Arrays arrays(const Level& l) {
    const GridShape& s = l.shape;
    Arrays a{.shape = s,
             .halving = l.halving,
             .g = {},
             .w = {},
             .sink = Values(s.cells()),
             .inverse = Values(s.cells()),
             .smoother = Values(s.cells())};
    for (int axis = 0; axis < 3; ++axis) {
      a.g[static_cast<std::size_t>(axis)].resize(face_count(s, axis));
    }
    const Values stencils = values(l.stencils);
    each(s, [&](const Cell& c) {
      const double* const of = stencils.data() + stencil_reals * stencil_of(s, c);
      double sum = of[7];
      for (int face = 0; face < 6; ++face) {
        a.face_at(face / 2, c, face % 2) = of[face];
        sum += of[face];
      }
      a.inverse[a.at(c)] = 1.0 / sum;
      a.smoother[a.at(c)] = of[6];
      a.sink[a.at(c)] = of[7];
    });
    // A face stands with both of its cells.
    each(s, [&](const Cell& c) {
      for (int face = 0; face < 6; ++face) {
        const double stands =
            stencils[stencil_reals * stencil_of(s, c) + static_cast<std::size_t>(face)];
        ASSERT_EQ(stands, a.face(face / 2, c, face % 2));
      }
    });
    return a;
  }
  /// Where a row's cells of one parity of x begin, in pairs of cells, and the cell among them.
  static std::size_t stencil_of(const GridShape& s, const Cell& c) {
    const auto row = static_cast<std::size_t>(c[2] * s.ny + c[1]);
    const auto pairs = static_cast<std::size_t>((s.nx + 1) / 2);
    return (2 * row + static_cast<std::size_t>(c[0] % 2)) * pairs +
           static_cast<std::size_t>(c[0] / 2);
  }
  /// Largest difference, relative to each expected value, above which a test fails: a few dozen
  /// roundings; 1 − w_i − w_j, where it is small, is small beside the other energies.
  static double allowed() { return 10 * rounding(); }
  static void expect_equal(const Values& got, const Values& expected, const std::string& what) {
    ASSERT_EQ(got.size(), expected.size()) << what;
    for (std::size_t i = 0; i < got.size(); ++i) {
      ASSERT_NEAR(got[i], expected[i], allowed() * expected[i]) << what << " at " << i;
    }
  }
  static void check_level(const Arrays& l, const std::string& where) {
    Values smoother;
    each(l.shape, [&](const Cell& c) { smoother.push_back(expected_smoother(l, c)); });
    expect_equal(l.smoother, smoother, where + ", smoother");
  }
  /// `weights`: those that the level holds, of red cells.
  static void check_coarsening(Arrays& l, const Values& weights, const Arrays& coarse,
                               const std::string& where) {
    Values sink(coarse.shape.cells(), 0.0);
    const auto parent = [&](const Cell& c, const GridShape& of, int across) {
      Cell p{};
      for (std::size_t a = 0; a < 3; ++a) {
        // Of faces across a halved axis, every second one and the last.
        p[a] = (c[a] + (static_cast<int>(a) == across ? l.halving[a] : 0)) >> l.halving[a];
      }
      return of.index(p[0], p[1], p[2]);
    };
    each(l.shape, [&](const Cell& c) { sink[parent(c, coarse.shape, -1)] += l.sink[l.at(c)]; });
    expect_equal(coarse.sink, sink, where + ", sink");
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      each(l.shape, [&](const Cell& c) {
        l.w[a].push_back(expected_weight(l, c, axis));
        if ((c[0] + c[1] + c[2]) % 2 != 0) return;
        const auto row = static_cast<std::size_t>(c[2] * l.shape.ny + c[1]);
        const std::size_t red = row * static_cast<std::size_t>((l.shape.nx + 1) / 2) +
                                static_cast<std::size_t>(c[0] / 2);
        ASSERT_NEAR(weights[weight_reals * red + a], l.w[a].back(), allowed() * l.w[a].back())
            << where << ", weights across axis " << axis;
      });
      GridShape fine_faces = l.shape, faces = coarse.shape;
      for (GridShape* s : {&fine_faces, &faces}) {
        (axis == 0 ? s->nx : axis == 1 ? s->ny : s->nz) += 1;
      }
      Values conductance(faces.cells(), 0.0);
      each(fine_faces, [&](const Cell& c) {
        if (l.halving[a] == 1 && c[a] % 2 == 1 && c[a] < l.shape.extent(axis)) return;
        conductance[parent(c, faces, axis)] += expected_conductance(l, c, axis);
      });
      expect_equal(coarse.g[a], conductance, where + ", faces across axis " + std::to_string(axis));
    }
  }
};

/// Odd and even extents, more cells in a row than an item holds at a time, and each set of axes:
/// random κ is halved along all of them, layers along two, or one where they are stacked.
TEST_P(GridLevels, EqualTheirDefinition) {
  for (const GridShape& shape :
       {GridShape{261, 6, 5, 0.25}, GridShape{130, 9, 3, 0.5}, GridShape{7, 13, 11, 0.3},
        GridShape{2, 3, 2, 1.0}, GridShape{1, 17, 6, 0.2}, GridShape{16, 1, 33, 0.3}}) {
    for (int layered = -1; layered < 3; ++layered) {
      auto [kappa, mu] = testing::random_medium(shape, 100, 71);
      each(shape, [&](const Cell& c) {
        if (layered >= 0 && c[static_cast<std::size_t>(layered)] % 2 == 1) {
          kappa[shape.index(c[0], c[1], c[2])] *= 1e-3;
        }
      });
      const Sides sides = layered == 1 ? Sides::mirror : Sides::open;
      Hierarchy hierarchy(context(), {single(), true}, Layout::gpu,
                          {.shape = shape, .sides = sides}, 2.34, 1);
      set_medium(hierarchy, kappa, mu);
      const std::vector<Level>& levels = hierarchy.levels();
      for (std::size_t l = 0; l < levels.size(); ++l) {
        const std::string where = std::to_string(shape.nx) + "x" + std::to_string(shape.ny) + "x" +
                                  std::to_string(shape.nz) + ", layers across " +
                                  std::to_string(layered) + ", level " + std::to_string(l);
        Arrays fine = arrays(levels[l]);
        check_level(fine, where);
        EXPECT_EQ(values(levels[l].smoother), fine.smoother) << where;
        if (l + 1 < levels.size()) {
          check_coarsening(fine, values(levels[l].weights), arrays(levels[l + 1]), where);
        }
      }
    }
  }
}

/// Both layouts hold the same numbers.
TEST_P(GridLevels, LayoutsHoldTheSame) {
  for (const GridShape& shape :
       {GridShape{13, 6, 5, 0.25}, GridShape{8, 1, 7, 0.5}, GridShape{1, 1, 1, 0.5}}) {
    const auto [kappa, mu] = testing::random_medium(shape, 100, 72);
    Hierarchy of_gpu(context(), {single(), true}, Layout::gpu, {.shape = shape}, 2.34, 1);
    Hierarchy of_cpu(context(), {single(), true}, Layout::cpu, {.shape = shape}, 2.34, 1);
    set_medium(of_gpu, kappa, mu);
    set_medium(of_cpu, kappa, mu);
    ASSERT_EQ(of_gpu.levels().size(), of_cpu.levels().size());
    for (std::size_t l = 0; l < of_gpu.levels().size(); ++l) {
      const Level &one = of_gpu.levels()[l], &other = of_cpu.levels()[l];
      const Values a = values(one.stencils), b = values(other.stencils);
      const Values v = values(one.weights), w = values(other.weights);
      each(one.shape, [&](const Cell& c) {
        const std::size_t at = stencil_of(one.shape, c);
        for (std::size_t k = at * stencil_reals; k < (at + 1) * stencil_reals; ++k) {
          EXPECT_EQ(a[k], b[k]);
        }
        if (one.shape.cells() == 1 || (c[0] + c[1] + c[2]) % 2 != 0) return;
        const auto row = static_cast<std::size_t>(c[2] * one.shape.ny + c[1]);
        const std::size_t red = row * static_cast<std::size_t>((one.shape.nx + 1) / 2) +
                                static_cast<std::size_t>(c[0] / 2);
        for (std::size_t k = red * weight_reals; k < (red + 1) * weight_reals; ++k) {
          EXPECT_EQ(v[k], w[k]);
        }
      });
    }
  }
}

/// The last level: inverse times (A φ) is φ, a GPU's cells standing in their order by colour.
TEST_P(GridLevels, TheLastHoldsTheInverse) {
  for (const Layout layout : {Layout::cpu, Layout::gpu}) {
    for (const GridShape& shape : {GridShape{13, 12, 10, 0.25}, GridShape{9, 2, 31, 0.5}}) {
      const auto [kappa, mu] = testing::random_medium(shape, 100, 73);
      Hierarchy hierarchy(context(), {single(), true}, layout, {.shape = shape}, 2.34);
      set_medium(hierarchy, kappa, mu);
      const Level& last = hierarchy.levels().back();
      const Arrays a = arrays(last);
      const GridShape& s = a.shape;
      ASSERT_GT(s.cells(), 1U);
      ASSERT_LE(s.cells(), 64U);
      const std::size_t places = layout == Layout::gpu ? 2 * half_cells(s) : s.cells();
      const auto place = [&](const Cell& c) {
        if (layout == Layout::cpu) return s.index(c[0], c[1], c[2]);
        const int colour = (c[0] + c[1] + c[2]) % 2;
        return static_cast<std::size_t>(((colour * s.nz + c[2]) * s.ny + c[1]) * ((s.nx + 1) / 2) +
                                        c[0] / 2);
      };
      const Values phi = testing::random_values(s.cells(), -1, 1, 74);
      Values image(places, 0.0), expected(places, 0.0);
      each(s, [&](const Cell& c) {
        double sum = a.sink[a.at(c)] * phi[a.at(c)];
        for (int axis = 0; axis < 3; ++axis) {
          for (int side = 0; side < 2; ++side) {
            Cell next = c;
            next[static_cast<std::size_t>(axis)] += side == 0 ? -1 : 1;
            const bool inside = next[static_cast<std::size_t>(axis)] >= 0 &&
                                next[static_cast<std::size_t>(axis)] < s.extent(axis);
            sum += a.face(axis, c, side) * (phi[a.at(c)] - (inside ? phi[a.at(next)] : 0.0));
          }
        }
        image[place(c)] = sum;
        expected[place(c)] = phi[a.at(c)];
      });
      const Values inverse = values(last.solve);
      ASSERT_EQ(inverse.size(), places * places);
      Values got(places, 0.0);
      for (std::size_t i = 0; i < places; ++i) {
        for (std::size_t k = 0; k < places; ++k) got[i] += inverse[k * places + i] * image[k];
      }
      EXPECT_LE(testing::relative_difference(got, expected), single() ? 1e-4 : 1e-11);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, GridLevels,
                         ::testing::Values(testing::opencl_single, testing::opencl_double),
                         testing::backend_name);

}  // namespace
}  // namespace kappamu::forward
