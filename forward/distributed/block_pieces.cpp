#include "forward/distributed/block_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"

namespace kappamu::forward::distributed {

namespace {

/// `ranks` as a product for the two axes across the light: the least halo, with a column at least
/// for each.
std::array<int, 3> split_face(const GridShape& shape, int light_axis, int ranks) {
  const int a = light_axis == 0 ? 1 : 0, b = light_axis == 2 ? 1 : 2;
  std::array<int, 3> best{1, 1, 1};
  double least = 0.0;
  for (int across = 1; across <= ranks; ++across) {
    const int up = ranks / across;
    if (across * up != ranks || across > shape.extent(a) || up > shape.extent(b)) continue;
    const double halo =
        static_cast<double>(across) * shape.extent(b) + static_cast<double>(up) * shape.extent(a);
    if (least > 0.0 && halo >= least) continue;
    least = halo;
    best[a] = across;
    best[b] = up;
  }
  if (least == 0.0) {
    throw InputError("a face of " + std::to_string(shape.extent(a)) + " x " +
                     std::to_string(shape.extent(b)) + " voxels cannot be cut into " +
                     std::to_string(ranks) + " rectangles; start fewer ranks");
  }
  return best;
}

}  // namespace

void require_countable(std::size_t numbers) {
  if (numbers <= static_cast<std::size_t>(std::numeric_limits<PetscInt>::max())) return;
  throw InputError(std::to_string(numbers) +
                   " unknowns are more than this PETSc counts; build with one of 64-bit integers "
                   "(Debian: libpetsc64-real-dev)");
}

BlockPieces::BlockPieces(MPI_Comm comm, const GridSetup& whole, int halvings)
    : comm_(comm), halvings_(halvings), whole_(whole), piece_(whole) {
  MPI_Comm_size(comm, &ranks_);
  const GridShape& s = whole.shape;
  require_countable(s.cells());
  const auto parts = split_face(s, axis_of(whole.lit_face), ranks_);
  const auto units = [&](int axis) { return ((s.extent(axis) - 1) >> halvings_) + 1; };
  for (int axis = 0; axis < 3; ++axis) {
    const int fewest = parts[axis] > 1 ? 2 * parts[axis] : 1;
    while (halvings_ > 0 && units(axis) < fewest) --halvings_;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int each = units(axis) / parts[axis], more = units(axis) % parts[axis];
    for (int part = 0; part < parts[axis]; ++part) {
      lengths_[axis].push_back((each + (part < more ? 1 : 0)) << halvings_);
    }
    lengths_[axis].back() -= (units(axis) << halvings_) - s.extent(axis);
  }
  cut(1);
}

BlockPieces::BlockPieces(MPI_Comm comm, const GridSetup& whole, Lengths lengths, int halo)
    : comm_(comm), whole_(whole), piece_(whole), lengths_(std::move(lengths)) {
  MPI_Comm_size(comm, &ranks_);
  require_countable(whole.shape.cells());
  cut(halo);
}

std::shared_ptr<const BlockPieces> BlockPieces::coarser() const {
  check(halvings_ > 0, "these pieces cannot be halved");
  GridSetup whole = whole_;
  const GridShape& s = whole_.shape;
  whole.shape = {(s.nx + 1) / 2, (s.ny + 1) / 2, (s.nz + 1) / 2, 2.0 * s.voxel_mm};
  Lengths lengths = lengths_;
  for (auto& along : lengths) {
    for (PetscInt& n : along) n = (n + 1) / 2;
  }
  std::shared_ptr<BlockPieces> pieces(new BlockPieces(comm_, whole, std::move(lengths), 1));
  pieces->halvings_ = halvings_ - 1;
  return pieces;
}

std::shared_ptr<const BlockPieces> BlockPieces::split(const GridSetup& whole) const {
  Lengths lengths = lengths_;
  for (int axis = 0; axis < 3; ++axis) {
    for (PetscInt& n : lengths[axis]) n *= 2;
    lengths[axis].back() -= 2 * whole_.shape.extent(axis) - whole.shape.extent(axis);
  }
  return std::shared_ptr<const BlockPieces>(new BlockPieces(comm_, whole, std::move(lengths), 2));
}

void BlockPieces::cut(int halo) {
  MPI_Comm_rank(comm_, &rank_);
  const GridShape& s = whole_.shape;
  const auto make = [&](DMDAStencilType stencil, int width, DM* grid) {
    const auto parts = [&](int axis) { return static_cast<PetscInt>(lengths_[axis].size()); };
    petsc(DMDACreate3d(comm_, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, stencil, s.nx,
                       s.ny, s.nz, parts(0), parts(1), parts(2), 1, width, lengths_[0].data(),
                       lengths_[1].data(), lengths_[2].data(), grid));
    petsc(DMDASetInterpolationType(*grid, DMDA_Q0));
    petsc(DMSetUp(*grid));
  };
  make(DMDA_STENCIL_STAR, 1, grid_.receive());
  make(DMDA_STENCIL_BOX, halo, halo_.receive());
  const auto box = [](auto corners, DM grid) {
    std::array<PetscInt, 3> first{}, extent{};
    petsc(corners(grid, &first[0], &first[1], &first[2], &extent[0], &extent[1], &extent[2]));
    Box result;
    for (int a = 0; a < 3; ++a) {
      result.begin[a] = static_cast<int>(first[a]);
      result.end[a] = static_cast<int>(first[a] + extent[a]);
    }
    return result;
  };
  owned_ = box(DMDAGetCorners, grid_.get());
  held_ = box(DMDAGetGhostCorners, halo_.get());
  piece_.shape = {held_.extent(0), held_.extent(1), held_.extent(2), s.voxel_mm};
}

std::array<int, 3> BlockPieces::offset() const {
  return {owned_.begin[0] - held_.begin[0], owned_.begin[1] - held_.begin[1],
          owned_.begin[2] - held_.begin[2]};
}

bool BlockPieces::owns(int x, int y, int z) const {
  const std::array<int, 3> at{x, y, z};
  for (int a = 0; a < 3; ++a) {
    const int in_whole = at[a] + held_.begin[a];
    if (in_whole < owned_.begin[a] || in_whole >= owned_.end[a]) return false;
  }
  return true;
}

bool BlockPieces::owns_pixel(Face face, int u, int v) const {
  const int axis = axis_of(face);
  const int last = whole_.shape.extent(axis) - 1;
  const int w = is_plus(face) ? last : 0;
  if (w < owned_.begin[axis] || w >= owned_.end[axis]) return false;
  std::array<int, 3> at{};
  const auto [u_axis, v_axis] = face_axes(face);
  at[axis] = w - held_.begin[axis];
  at[u_axis] = u;
  at[v_axis] = v;
  return owns(at[0], at[1], at[2]);
}

Vector BlockPieces::make_vector() const {
  Vector vector;
  petsc(DMCreateGlobalVector(grid(), vector.receive()));
  return vector;
}

void BlockPieces::read(Vec vector, std::span<double> values) const {
  Vec piece = nullptr;
  petsc(DMGetLocalVector(halo_.get(), &piece));
  petsc(VecPlaceArray(piece, values.data()));
  petsc(DMGlobalToLocal(halo_.get(), vector, INSERT_VALUES, piece));
  petsc(VecResetArray(piece));
  petsc(DMRestoreLocalVector(halo_.get(), &piece));
}

void BlockPieces::fill(Vec vector, std::span<const double> values) const {
  const Values own(vector);
  for_own([&](std::size_t i, std::size_t k) { own[k] = values[i]; });
}

void BlockPieces::exchange(std::span<double> values) const {
  Vec whole = nullptr;
  petsc(DMGetGlobalVector(grid(), &whole));
  fill(whole, values);
  read(whole, values);
  petsc(DMRestoreGlobalVector(grid(), &whole));
}

void BlockPieces::sum(std::span<double> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                comm_);
}

double BlockPieces::sum(double value) const {
  sum(std::span(&value, 1));
  return value;
}

}  // namespace kappamu::forward::distributed
