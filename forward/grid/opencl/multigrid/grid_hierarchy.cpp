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
std::vector<double> downloaded(device::Context& context, const Format& format,
                               const device::Buffer& buffer) {
  std::vector<double> values(buffer.bytes() / format.real_bytes());
  if (!format.single) {
    context.read(buffer, values.data(), buffer.bytes());
    return values;
  }
  std::vector<float> rounded(values.size());
  context.read(buffer, rounded.data(), buffer.bytes());
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
      program_(level_program(context, format, layout)) {
  const std::size_t unit = format.real_bytes();
  kappa_ = context.allocate(setup.shape.cells() * unit);
  mu_ = context.allocate(setup.shape.cells() * unit);
  levels_.push_back(allocate_level(setup.shape));
}

Level Hierarchy::allocate_level(const GridShape& shape) const {
  const std::size_t unit = format_.real_bytes();
  Level level;
  level.shape = shape;
  level.gx = context_.allocate(face_count(shape, 0) * unit);
  level.gy = context_.allocate(face_count(shape, 1) * unit);
  level.gz = context_.allocate(face_count(shape, 2) * unit);
  std::vector<device::Buffer*> fields{&level.sink, &level.inverse};
  if (layout_ == Layout::cpu && !levels_.empty()) {
    const Level& lender = levels_.front();
    level.smoother = lender.smoother;
    level.wx = lender.wx;
    level.wy = lender.wy;
    level.wz = lender.wz;
  } else {
    fields.push_back(&level.smoother);
    if (shape.cells() > 1) fields.insert(fields.end(), {&level.wx, &level.wy, &level.wz});
  }
  for (device::Buffer* field : fields) *field = context_.allocate(shape.cells() * unit);
  level.stencils = context_.allocate(2 * half_cells(shape) * stencil_reals * unit);
  level.weights = context_.allocate(half_cells(shape) * weight_reals * unit);
  return level;
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

std::array<int, 3> Hierarchy::strong_axes(const Level& level) const {
  const GridShape& s = level.shape;
  const std::size_t rows = s.cells() / static_cast<std::size_t>(s.nx);
  const device::Buffer shares = context_.allocate(3 * rows * format_.accu_bytes());
  const std::size_t items = layout_ == Layout::gpu ? row_items : 1;
  context_.launch(program_, "axis_shares", {items, rows, items, 1}, s.nx, s.ny, s.nz, level.gx,
                  level.gy, level.gz, level.inverse, shares);
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

bool Hierarchy::set_medium(std::span<const double> kappa, std::span<const double> mu) {
  upload(context_, format_, kappa, kappa_);
  upload(context_, format_, mu, mu_);
  return assemble();
}

bool Hierarchy::assemble() {
  const Level& level = levels_.front();
  const GridShape& s = level.shape;
  const auto finest = [&](auto h, auto A) {
    context_.launch(program_, "assemble", scalar_rows(layout_, s), s.nx, s.ny, s.nz, h, A,
                    int{is_open(setup_, Face::x_minus)}, int{is_open(setup_, Face::y_minus)},
                    int{is_open(setup_, Face::z_minus)}, kappa_, mu_, level.gx, level.gy, level.gz,
                    level.sink);
  };
  if (format_.single) {
    finest(static_cast<float>(s.voxel_mm), static_cast<float>(robin_A_));
  } else {
    finest(s.voxel_mm, robin_A_);
  }
  bool changed = false;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& at = levels_[l];
    // Until the level is coarsened its smoother's place holds what places the nodes.
    const device::Buffer& loose = at.smoother;
    context_.launch(program_, "invert_diagonal", scalar_rows(layout_, at.shape), at.shape.nx,
                    at.shape.ny, at.shape.nz, at.gx, at.gy, at.gz, at.sink, at.inverse, loose);
    if (!is_last(l)) {
      const std::array<int, 3> before = at.halving;
      at.halving = strong_axes(at);
      changed = ensure_level(l + 1) || before != at.halving || changed;
      coarsen(levels_[l], levels_[l + 1]);
    } else {
      changed = changed || l + 1 < levels_.size();
      levels_.resize(l + 1);
    }
    make_smoother(levels_[l]);
    pack_stencils(levels_[l]);
  }
  if (layout_ == Layout::gpu) invert_matrix(levels_.back());
  has_medium_ = true;
  return changed;
}

bool Hierarchy::is_last(std::size_t l) const {
  const std::size_t cells = levels_[l].shape.cells();
  return cells == 1 || (layout_ == Layout::gpu && l > 0 && cells <= cells_to_invert_);
}

void Hierarchy::invert_matrix(Level& level) const {
  const GridShape& s = level.shape;
  const auto place = [&](int x, int y, int z) {
    const int colour = (x ^ y ^ z) & 1;
    return ((colour * s.nz + z) * s.ny + y) * ((s.nx + 1) / 2) + x / 2;
  };
  const std::vector<double> gx = downloaded(context_, format_, level.gx),
                            gy = downloaded(context_, format_, level.gy),
                            gz = downloaded(context_, format_, level.gz),
                            sink = downloaded(context_, format_, level.sink);
  const auto places = static_cast<Eigen::Index>(2 * half_cells(s));
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

void Hierarchy::make_smoother(const Level& level) const {
  const GridShape& s = level.shape;
  const auto launch = [&](auto omega) {
    context_.launch(program_, "make_smoother", scalar_rows(layout_, s), s.nx, s.ny, s.nz, omega,
                    level.gx, level.gy, level.gz, level.sink, level.inverse, level.smoother);
  };
  if (format_.single) {
    launch(static_cast<float>(damping));
  } else {
    launch(damping);
  }
}

void Hierarchy::pack_stencils(const Level& level) const {
  const GridShape& s = level.shape;
  const bool last = level.shape.cells() == levels_.back().shape.cells();
  context_.launch(program_, "pack_stencils", scalar_rows(layout_, s), s.nx, s.ny, s.nz, level.gx,
                  level.gy, level.gz, level.sink, level.smoother, int{!last},
                  last ? level.sink : level.wx, last ? level.sink : level.wy,
                  last ? level.sink : level.wz, level.stencils, level.weights);
}

void Hierarchy::sum_children(const GridShape& fine, const GridShape& coarse,
                             const std::array<int, 3>& halving, const device::Buffer& values,
                             const device::Buffer& sums) const {
  context_.launch(program_, "sum_children", scalar_rows(layout_, coarse), fine.nx, fine.ny, fine.nz,
                  coarse.nx, coarse.ny, coarse.nz, halving[0], halving[1], halving[2], values,
                  sums);
}

void Hierarchy::coarsen(const Level& fine, const Level& coarse) {
  const GridShape& f = fine.shape;
  const std::array<int, 3>& half = fine.halving;
  const std::array<const device::Buffer*, 3> fine_faces{&fine.gx, &fine.gy, &fine.gz};
  const std::array<const device::Buffer*, 3> coarse_faces{&coarse.gx, &coarse.gy, &coarse.gz};
  const std::array<const device::Buffer*, 3> weights{&fine.wx, &fine.wy, &fine.wz};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const GridShape faces = with_faces(coarse.shape, axis);
    if (half[a] == 0) {
      context_.zero(*weights[a], f.cells() * format_.real_bytes());
      sum_children(with_faces(f, axis), faces, half, *fine_faces[a], *coarse_faces[a]);
    } else if (axis == 0) {
      context_.launch(program_, "weights_in_rows", scalar_rows(layout_, f), f.nx, f.ny, f.nz,
                      fine.gx, fine.smoother, fine.wx);
      context_.launch(program_, "coarsen_faces_in_rows", scalar_rows(layout_, faces), f.nx, f.ny,
                      f.nz, half[1], half[2], fine.gx, fine.gy, fine.gz, fine.smoother, fine.wx,
                      coarse.gx);
    } else {
      const std::size_t other = 3 - a;
      std::array<int, 3> alone{};
      alone[a] = 1;
      const GridShape face_rows = with_faces(coarser_grid(f, alone), axis);
      context_.launch(program_, "weights_between_rows", scalar_rows(layout_, face_rows), axis, f.nx,
                      f.ny, f.nz, *fine_faces[a], fine.smoother, *weights[a]);
      context_.launch(program_, "coarsen_faces_between_rows", scalar_rows(layout_, faces), axis,
                      f.nx, f.ny, f.nz, half[0], half[other], fine.gx, *fine_faces[a],
                      *fine_faces[other], fine.smoother, *weights[a], *coarse_faces[a]);
    }
  }
  sum_children(f, coarse.shape, half, fine.sink, coarse.sink);
}

}  // namespace kappamu::forward
