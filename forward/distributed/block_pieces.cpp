#include "forward/distributed/block_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.h"

namespace kappamu::forward::distributed {

namespace {

/// `ranks` as a product for the two axes across the light: the least halo, with a column at least
/// for each.
std::array<int, 3> split(const GridShape& shape, int light_axis, int ranks) {
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

BlockPieces::BlockPieces(MPI_Comm comm, const GridSetup& whole)
    : comm_(comm), whole_(whole), piece_(whole) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &ranks_);
  const GridShape& s = whole.shape;
  require_countable(s.cells());
  const auto parts = split(s, axis_of(whole.lit_face), ranks_);
  petsc(DMDACreate3d(comm, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_STAR,
                     s.nx, s.ny, s.nz, parts[0], parts[1], parts[2], 1, 1, nullptr, nullptr,
                     nullptr, grid_.receive()));
  petsc(DMDASetInterpolationType(grid_.get(), DMDA_Q0));
  petsc(DMSetUp(grid_.get()));
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
  held_ = box(DMDAGetGhostCorners, grid_.get());
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

Vector BlockPieces::make_piece() const {
  Vector vector;
  petsc(DMCreateLocalVector(grid(), vector.receive()));
  return vector;
}

void BlockPieces::read(Vec vector, std::span<double> values) const {
  Vec piece = nullptr;
  petsc(DMGetLocalVector(grid(), &piece));
  petsc(VecPlaceArray(piece, values.data()));
  petsc(DMGlobalToLocal(grid(), vector, INSERT_VALUES, piece));
  petsc(VecResetArray(piece));
  petsc(DMRestoreLocalVector(grid(), &piece));
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
