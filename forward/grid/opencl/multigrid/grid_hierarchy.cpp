#include "forward/grid/opencl/multigrid/grid_hierarchy.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "core/numbers/linear_algebra.h"
#include "core/parallel.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::forward {

namespace {

/// ω of make_smoother.
constexpr double damping = 5.0 / 6.0;
/// An axis is halved where its mean share of conductance is at least this part of the largest.
constexpr double strong = 0.5;
/// Items that add up a row with Layout::gpu; ROW_ITEMS in grid_assemble.cl.
constexpr std::size_t row_items = 32;

/// The array of faces across `axis`.
GridShape with_faces(GridShape s, int axis) {
  (axis == 0 ? s.nx : axis == 1 ? s.ny : s.nz) += 1;
  return s;
}

}  // namespace

GridShape coarser_grid(const GridShape& s, const std::array<int, 3>& halving) {
  return {(s.nx + halving[0]) >> halving[0], (s.ny + halving[1]) >> halving[1],
          (s.nz + halving[2]) >> halving[2], s.voxel_mm};
}

std::size_t face_count(const GridShape& shape, int axis) {
  return with_faces(shape, axis).cells();
}

void upload(device::Context& context, const Format& format, std::span<const double> values,
            const device::Buffer& buffer) {
  if (!format.single) {
    context.write(buffer, values.data(), values.size_bytes());
    return;
  }
  std::vector<float> rounded(values.size());
  for_pieces(values.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) rounded[i] = static_cast<float>(values[i]);
  });
  context.write(buffer, rounded.data(), rounded.size() * sizeof(float));
}

device::Buffer uploaded(device::Context& context, const Format& format,
                        std::span<const double> values) {
  device::Buffer buffer = context.allocate(values.size() * format.real_bytes());
  upload(context, format, values, buffer);
  return buffer;
}

namespace {
/// The first `count` values.
std::vector<double> downloaded(device::Context& context, const Format& format,
                               const device::Buffer& buffer, std::size_t count) {
  std::vector<double> values(count);
  if (!format.single) {
    context.read(buffer, values.data(), count * sizeof(double));
    return values;
  }
  std::vector<float> rounded(count);
  context.read(buffer, rounded.data(), count * sizeof(float));
  std::copy(rounded.begin(), rounded.end(), values.begin());
  return values;
}
}  // namespace

std::size_t half_cells(const GridShape& shape) {
  const auto nx = static_cast<std::size_t>(shape.nx);
  return shape.cells() / nx * ((nx + 1) / 2);
}

Hierarchy::Hierarchy(device::Context& context, const Format& format, Layout layout,
                     const GridSetup& setup, double robin_A, std::size_t cells_to_invert)
    : context_(context),
      format_(format),
      layout_(layout),
      setup_(setup),
      robin_A_(robin_A),
      cells_to_invert_(cells_to_invert),
      program_(level_program(context, format, layout)),
      workspace_(context) {
  levels_.push_back(allocate_level(setup.shape));
}

Level Hierarchy::allocate_level(const GridShape& shape) const {
  const std::size_t unit = format_.real_bytes();
  Level level;
  level.shape = shape;
  level.stencils = context_.allocate(2 * half_cells(shape) * stencil_reals * unit);
  level.weights = context_.allocate(half_cells(shape) * weight_reals * unit);
  if (layout_ == Layout::gpu) level.smoother = context_.allocate(shape.cells() * unit);
  return level;
}

Hierarchy::Arrays Hierarchy::take_arrays(const GridShape& shape) const {
  const auto take = [&](std::size_t count) {
    return workspace_.take(count * format_.real_bytes());
  };
  return {take(face_count(shape, 0)), take(face_count(shape, 1)), take(face_count(shape, 2)),
          take(shape.cells())};
}

bool Hierarchy::ensure_level(std::size_t l) {
  const GridShape shape = coarser_grid(levels_[l - 1].shape, levels_[l - 1].halving);
  if (l < levels_.size()) {
    const GridShape& old = levels_[l].shape;
    if (old.nx == shape.nx && old.ny == shape.ny && old.nz == shape.nz) return false;
    levels_.resize(l);
  }
  levels_.push_back(allocate_level(shape));
  return true;
}

std::array<int, 3> Hierarchy::strong_axes(const GridShape& s, const Arrays& fine,
                                          const device::Buffer& inverse) const {
  const std::size_t rows = s.cells() / static_cast<std::size_t>(s.nx);
  const device::Buffer shares = context_.allocate(3 * rows * format_.accu_bytes());
  const std::size_t items = layout_ == Layout::gpu ? row_items : 1;
  context_.launch(program_, "axis_shares", {items, rows, items, 1}, s.nx, s.ny, s.nz, fine.gx,
                  fine.gy, fine.gz, inverse, shares);
  std::array<double, 3> sum{};
  const auto add_up = [&](auto zero) {
    std::vector<decltype(zero)> values(3 * rows);
    context_.read(shares, values.data(), values.size() * sizeof(zero));
    for (std::size_t i = 0; i < values.size(); ++i) sum[i % 3] += static_cast<double>(values[i]);
  };
  if (format_.accurate_sums) {
    add_up(0.0);
  } else {
    add_up(0.0F);
  }
  double largest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (s.extent(axis) > 1) largest = std::max(largest, sum[static_cast<std::size_t>(axis)]);
  }
  std::array<int, 3> halving{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    halving[a] = s.extent(axis) == 1 || sum[a] >= strong * largest ? 1 : 0;
  }
  return halving;
}

bool Hierarchy::set_medium(const device::Buffer& kappa, const device::Buffer& mu) {
  const GridShape& s = levels_.front().shape;
  const std::size_t field = s.cells() * format_.real_bytes();
  workspace_.begin(0);
  SetUp set_up;
  set_up.of_level[0] = take_arrays(s);
  for (device::Buffer* place : {&set_up.inverse, &set_up.loose, &set_up.weight}) {
    *place = workspace_.take(field);
  }
  const auto assemble = [&](auto h, auto A) {
    const Arrays& to = set_up.of_level[0];
    context_.launch(program_, "assemble", scalar_rows(layout_, s), s.nx, s.ny, s.nz, h, A,
                    int{is_open(setup_, Face::x_minus)}, int{is_open(setup_, Face::y_minus)},
                    int{is_open(setup_, Face::z_minus)}, kappa, mu, to.gx, to.gy, to.gz, to.sink);
  };
  if (format_.single) {
    assemble(static_cast<float>(s.voxel_mm), static_cast<float>(robin_A_));
  } else {
    assemble(s.voxel_mm, robin_A_);
  }
  bool changed = false;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const GridShape shape = levels_[l].shape;
    const Arrays& from = set_up.of_level[l % 2];
    context_.launch(program_, "invert_diagonal", scalar_rows(layout_, shape), shape.nx, shape.ny,
                    shape.nz, from.gx, from.gy, from.gz, from.sink, set_up.inverse, set_up.loose);
    if (!is_last(l)) {
      const std::array<int, 3> before = levels_[l].halving;
      levels_[l].halving = strong_axes(shape, from, set_up.inverse);
      changed = ensure_level(l + 1) || before != levels_[l].halving || changed;
      const GridShape below = levels_[l + 1].shape;
      // Levels further down find room in the places of those two above.
      if (l == 0) set_up.of_level[1] = take_arrays(below);
      coarsen(levels_[l], below, from, set_up.of_level[1 - l % 2], set_up);
    } else {
      changed = changed || l + 1 < levels_.size();
      levels_.resize(l + 1);
      invert_matrix(levels_[l], from);
    }
    const Level& level = levels_[l];
    const device::Buffer& smoother = layout_ == Layout::gpu ? level.smoother : set_up.loose;
    make_smoother(shape, from, set_up.inverse, smoother);
    context_.launch(program_, "pack_stencils", scalar_rows(layout_, shape), shape.nx, shape.ny,
                    shape.nz, from.gx, from.gy, from.gz, from.sink, smoother, level.stencils);
  }
  has_medium_ = true;
  return changed;
}

bool Hierarchy::is_last(std::size_t l) const {
  const std::size_t cells = levels_[l].shape.cells();
  return cells == 1 || (l > 0 && cells <= cells_to_invert_);
}

void Hierarchy::invert_matrix(Level& level, const Arrays& arrays) const {
  const GridShape& s = level.shape;
  const bool by_colour = layout_ == Layout::gpu;
  const auto place = [&](int x, int y, int z) {
    if (!by_colour) return static_cast<int>(s.index(x, y, z));
    const int colour = (x ^ y ^ z) & 1;
    return ((colour * s.nz + z) * s.ny + y) * ((s.nx + 1) / 2) + x / 2;
  };
  const auto faces = [&](int axis, const device::Buffer& buffer) {
    return downloaded(context_, format_, buffer, face_count(s, axis));
  };
  const std::vector<double> gx = faces(0, arrays.gx), gy = faces(1, arrays.gy),
                            gz = faces(2, arrays.gz),
                            sink = downloaded(context_, format_, arrays.sink, s.cells());
  const auto places = static_cast<Eigen::Index>(by_colour ? 2 * half_cells(s) : s.cells());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(places, places);
  const auto add_face = [&](double g, int here, bool inside, int there) {
    matrix(here, here) += g;
    if (inside) matrix(here, there) -= g;
  };
  for (int z = 0; z < s.nz; ++z) {
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) {
        const int here = place(x, y, z);
        const auto cell = s.index(x, y, z);
        const auto face_x = cell + static_cast<std::size_t>(z * s.ny + y),
                   face_y = cell + static_cast<std::size_t>(z * s.nx);
        const auto nx = static_cast<std::size_t>(s.nx), plane = nx * static_cast<std::size_t>(s.ny);
        matrix(here, here) += sink[cell];
        add_face(gx[face_x], here, x > 0, place(x - 1, y, z));
        add_face(gx[face_x + 1], here, x + 1 < s.nx, place(x + 1, y, z));
        add_face(gy[face_y], here, y > 0, place(x, y - 1, z));
        add_face(gy[face_y + nx], here, y + 1 < s.ny, place(x, y + 1, z));
        add_face(gz[cell], here, z > 0, place(x, y, z - 1));
        add_face(gz[cell + plane], here, z + 1 < s.nz, place(x, y, z + 1));
      }
    }
  }
  // Places of odd rows that no cell has.
  const Eigen::VectorXd cells =
      matrix.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 : 0.0; });
  matrix.diagonal() += Eigen::VectorXd::Ones(places) - cells;
  const Eigen::MatrixXd inverse = inverse_definite(matrix) * cells.asDiagonal();
  level.solve =
      uploaded(context_, format_, {inverse.data(), static_cast<std::size_t>(inverse.size())});
}

void Hierarchy::make_smoother(const GridShape& s, const Arrays& arrays,
                              const device::Buffer& inverse, const device::Buffer& smoother) const {
  const auto launch = [&](auto omega) {
    context_.launch(program_, "make_smoother", scalar_rows(layout_, s), s.nx, s.ny, s.nz, omega,
                    arrays.gx, arrays.gy, arrays.gz, arrays.sink, inverse, smoother);
  };
  if (format_.single) {
    launch(static_cast<float>(damping));
  } else {
    launch(damping);
  }
}

void Hierarchy::sum_children(const GridShape& fine, const GridShape& coarse,
                             const std::array<int, 3>& halving, const device::Buffer& values,
                             const device::Buffer& sums) const {
  context_.launch(program_, "sum_children", scalar_rows(layout_, coarse), fine.nx, fine.ny, fine.nz,
                  coarse.nx, coarse.ny, coarse.nz, halving[0], halving[1], halving[2], values,
                  sums);
}

void Hierarchy::coarsen(const Level& level, const GridShape& below, const Arrays& fine,
                        const Arrays& coarse, const SetUp& set_up) const {
  const GridShape& f = level.shape;
  const std::array<int, 3>& half = level.halving;
  const device::Buffer &loose = set_up.loose, &weight = set_up.weight;
  const std::array<const device::Buffer*, 3> fine_faces{&fine.gx, &fine.gy, &fine.gz};
  const std::array<const device::Buffer*, 3> coarse_faces{&coarse.gx, &coarse.gy, &coarse.gz};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const GridShape faces = with_faces(below, axis);
    if (half[a] == 0) {
      context_.zero(weight, f.cells() * format_.real_bytes());
      sum_children(with_faces(f, axis), faces, half, *fine_faces[a], *coarse_faces[a]);
    } else if (axis == 0) {
      context_.launch(program_, "weights_in_rows", scalar_rows(layout_, f), f.nx, f.ny, f.nz,
                      fine.gx, loose, weight);
      context_.launch(program_, "coarsen_faces_in_rows", scalar_rows(layout_, faces), f.nx, f.ny,
                      f.nz, half[1], half[2], fine.gx, fine.gy, fine.gz, loose, weight, coarse.gx);
    } else {
      const std::size_t other = 3 - a;
      std::array<int, 3> alone{};
      alone[a] = 1;
      const GridShape face_rows = with_faces(coarser_grid(f, alone), axis);
      context_.launch(program_, "weights_between_rows", scalar_rows(layout_, face_rows), axis, f.nx,
                      f.ny, f.nz, *fine_faces[a], loose, weight);
      context_.launch(program_, "coarsen_faces_between_rows", scalar_rows(layout_, faces), axis,
                      f.nx, f.ny, f.nz, half[0], half[other], fine.gx, *fine_faces[a],
                      *fine_faces[other], loose, weight, *coarse_faces[a]);
    }
    context_.launch(program_, "pack_weights", scalar_rows(layout_, f), axis, f.nx, f.ny, f.nz,
                    weight, level.weights);
  }
  sum_children(f, below, half, fine.sink, coarse.sink);
}

}  // namespace kappamu::forward
