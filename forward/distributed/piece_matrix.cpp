#include "forward/distributed/piece_matrix.h"

#include <array>

#include "core/optics.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::forward::distributed {

Matrix make_matrix(const BlockPieces& pieces) {
  Matrix matrix;
  petsc(DMSetMatType(pieces.grid(), MATAIJ));
  petsc(DMCreateMatrix(pieces.grid(), matrix.receive()));
  petsc(MatSetOption(matrix.get(), MAT_SPD, PETSC_TRUE));
  return matrix;
}

void assemble(const BlockPieces& pieces, double A, std::span<const double> kappa,
              std::span<const double> mu, Mat matrix) {
  const GridShape& piece = pieces.piece().shape;
  const GridShape& whole = pieces.whole().shape;
  const Box& held = pieces.held();
  const double h = whole.voxel_mm;
  std::array<bool, 6> open{};
  for (const Face f : all_faces) open[static_cast<std::size_t>(f)] = is_open(pieces.whole(), f);
  std::array<MatStencil, 7> columns{};
  std::array<double, 7> values{};
  pieces.for_own([&](std::size_t i, std::size_t) {
    const auto nx = static_cast<std::size_t>(piece.nx), ny = static_cast<std::size_t>(piece.ny);
    const std::array<int, 3> at{static_cast<int>(i % nx) + held.begin[0],
                                static_cast<int>(i / nx % ny) + held.begin[1],
                                static_cast<int>(i / nx / ny) + held.begin[2]};
    const std::array<std::size_t, 3> step{1, nx, nx * ny};
    const auto stencil = [](const std::array<int, 3>& p) {
      return MatStencil{p[2], p[1], p[0], 0};
    };
    double diagonal = mu[i] * h * h * h;
    PetscInt count = 0;
    for (const Face face : all_faces) {
      const int axis = axis_of(face), way = is_plus(face) ? 1 : -1;
      std::array<int, 3> neighbour = at;
      neighbour[axis] += way;
      if (neighbour[axis] < 0 || neighbour[axis] >= whole.extent(axis)) {
        if (open[static_cast<std::size_t>(face)]) diagonal += robin_conductance(kappa[i], h, A);
        continue;
      }
      const double other = kappa[way > 0 ? i + step[axis] : i - step[axis]];
      const double conductance = 2.0 * h * kappa[i] * other / (kappa[i] + other);
      diagonal += conductance;
      columns[count] = stencil(neighbour);
      values[count++] = -conductance;
    }
    const MatStencil row = stencil(at);
    columns[count] = row;
    values[count++] = diagonal;
    petsc(
        MatSetValuesStencil(matrix, 1, &row, count, columns.data(), values.data(), INSERT_VALUES));
  });
  petsc(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  petsc(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

}  // namespace kappamu::forward::distributed
