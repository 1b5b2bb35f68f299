#include "studies/baseline/stencil.h"

#include "core/error.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::studies::baseline {

namespace {

/// Calls visit(cell, {x, y, z}) for every cell in memory order.
template <class Visit>
void for_each_cell(const std::array<int, 3>& n, const Visit& visit) {
  std::size_t i = 0;
  for (int z = 0; z < n[2]; ++z) {
    for (int y = 0; y < n[1]; ++y) {
      for (int x = 0; x < n[0]; ++x) visit(i++, std::array<int, 3>{x, y, z});
    }
  }
}

std::array<int, 3> extents(const Bricks& bricks) {
  return {bricks.extent(0), bricks.extent(1), bricks.extent(2)};
}

double width(const Bricks& bricks, std::size_t axis, const std::array<int, 3>& at) {
  return bricks.width[axis][static_cast<std::size_t>(at[axis])];
}

double volume(const Bricks& bricks, const std::array<int, 3>& at) {
  return width(bricks, 0, at) * width(bricks, 1, at) * width(bricks, 2, at);
}

std::size_t stride(const std::array<int, 3>& n, std::size_t axis) {
  std::size_t product = 1;
  for (std::size_t a = 0; a < axis; ++a) product *= static_cast<std::size_t>(n[a]);
  return product;
}

/// Assembles what both stencils share: `link(axis, i, j, at)` and `robin(axis, i, at)` give G of
/// inner and open boundary faces.
template <class Link, class Robin>
Stencil assemble(const GridSetup& setup, const std::array<int, 3>& n, std::vector<double> sink,
                 const Link& link, const Robin& robin) {
  Stencil stencil;
  stencil.n = n;
  stencil.sink = std::move(sink);
  std::vector<double> diagonal = stencil.sink;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<int, 3> faces = n;
    ++faces[axis];
    auto& g = stencil.face[axis];
    g.assign(stride(faces, 3), 0.0);
    const std::size_t step = stride(n, axis), face_step = stride(faces, axis);
    const bool open_minus = is_open(setup, all_faces[2 * axis]);
    const bool open_plus = is_open(setup, all_faces[2 * axis + 1]);
    for_each_cell(n, [&](std::size_t i, const std::array<int, 3>& at) {
      const auto x = static_cast<std::size_t>(at[0]), y = static_cast<std::size_t>(at[1]);
      const std::size_t below =
          x + static_cast<std::size_t>(faces[0]) *
                  (y + static_cast<std::size_t>(faces[1]) * static_cast<std::size_t>(at[2]));
      if (at[axis] == 0 && open_minus) g[below] = robin(axis, i, at);
      if (at[axis] + 1 < n[axis]) {
        g[below + face_step] = link(axis, i, i + step, at);
      } else if (open_plus) {
        g[below + face_step] = robin(axis, i, at);
      }
      diagonal[i] += g[below] + g[below + face_step];
    });
  }
  stencil.inverse = std::move(diagonal);
  for (double& d : stencil.inverse) {
    if (!(d > 0.0)) {
      throw InputError(
          "a single voxel between mirrors that absorbs nothing has no answer; open its sides or "
          "give it absorption");
    }
    d = 1.0 / d;
  }
  return stencil;
}

}  // namespace

Bricks bricks_of(const GridShape& shape) {
  Bricks bricks;
  for (int axis = 0; axis < 3; ++axis) {
    bricks.width[static_cast<std::size_t>(axis)].assign(
        static_cast<std::size_t>(shape.extent(axis)), shape.voxel_mm);
  }
  return bricks;
}

Bricks coarsened(const Bricks& fine) {
  Bricks coarse;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& w = fine.width[axis];
    for (std::size_t i = 0; i < w.size(); i += 2) {
      coarse.width[axis].push_back(w[i] + (i + 1 < w.size() ? w[i + 1] : 0.0));
    }
  }
  return coarse;
}

std::vector<double> children_mean(const Bricks& fine, const Bricks& coarse,
                                  const std::vector<double>& values) {
  std::vector<double> mean(coarse.cells(), 0.0);
  const std::array<int, 3> n = extents(coarse);
  for_each_cell(extents(fine), [&](std::size_t i, const std::array<int, 3>& at) {
    const std::size_t parent = static_cast<std::size_t>(at[0] / 2) * stride(n, 0) +
                               static_cast<std::size_t>(at[1] / 2) * stride(n, 1) +
                               static_cast<std::size_t>(at[2] / 2) * stride(n, 2);
    mean[parent] += values[i] * volume(fine, at);
  });
  for_each_cell(
      n, [&](std::size_t i, const std::array<int, 3>& at) { mean[i] /= volume(coarse, at); });
  return mean;
}

Stencil conservative_stencil(const GridSetup& setup, double robin_A, const Bricks& bricks,
                             const std::vector<double>& kappa, const std::vector<double>& mu) {
  const std::array<int, 3> n = extents(bricks);
  std::vector<double> sink(bricks.cells());
  for_each_cell(n, [&](std::size_t i, const std::array<int, 3>& at) {
    sink[i] = mu[i] * volume(bricks, at);
  });
  const auto half_resistance = [&](std::size_t axis, std::size_t i, const std::array<int, 3>& at) {
    return width(bricks, axis, at) / (2.0 * kappa[i]);
  };
  const auto area = [&](std::size_t axis, const std::array<int, 3>& at) {
    return volume(bricks, at) / width(bricks, axis, at);
  };
  return assemble(
      setup, n, std::move(sink),
      [&](std::size_t axis, std::size_t i, std::size_t j, const std::array<int, 3>& at) {
        std::array<int, 3> next = at;
        ++next[axis];
        return area(axis, at) / (half_resistance(axis, i, at) + half_resistance(axis, j, next));
      },
      [&](std::size_t axis, std::size_t i, const std::array<int, 3>& at) {
        return area(axis, at) / (half_resistance(axis, i, at) + 2.0 * robin_A);
      });
}

Stencil wang2008_stencil(const GridSetup& setup, double robin_A, const std::vector<double>& kappa,
                         const std::vector<double>& mu) {
  const double h = setup.shape.voxel_mm;
  std::vector<double> sink(kappa.size());
  for (std::size_t i = 0; i < kappa.size(); ++i) sink[i] = mu[i] * h * h * h / kappa[i];
  return assemble(
      setup, {setup.shape.nx, setup.shape.ny, setup.shape.nz}, std::move(sink),
      [&](std::size_t, std::size_t, std::size_t, const std::array<int, 3>&) { return h; },
      [&](std::size_t, std::size_t i, const std::array<int, 3>&) {
        return h * h / (h / 2.0 + 2.0 * robin_A * kappa[i]);
      });
}

}  // namespace kappamu::studies::baseline
