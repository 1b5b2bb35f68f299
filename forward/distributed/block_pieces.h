// A block cut between the ranks of MPI: each owns the columns along the light of a rectangle of the
// lit face, so that a beam never leaves its rank.
//
// The piece of a rank is what it owns and, towards each neighbour, a halo one voxel wide: a smaller
// block of its own, whose arrays are [z][y][x] as any block's. Every rank of the communicator makes
// the same calls in the same order.
#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "forward/block_setup.h"
#include "forward/distributed/petsc.h"

namespace kappamu::forward::distributed {

/// Voxels [begin, end) along x, y and z.
struct Box {
  std::array<int, 3> begin{};
  std::array<int, 3> end{};

  int extent(int axis) const { return end[axis] - begin[axis]; }
  std::size_t cells() const {
    return static_cast<std::size_t>(extent(0)) * extent(1) * static_cast<std::size_t>(extent(2));
  }
};

/// Throws InputError where a vector over all ranks has more numbers than PETSc's integers count.
void require_countable(std::size_t numbers);

class BlockPieces {
 public:
  /// Throws InputError, on every rank, where the block has fewer columns than there are ranks.
  BlockPieces(MPI_Comm comm, const GridSetup& whole);

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  DM grid() const { return grid_.get(); }
  const GridSetup& whole() const { return whole_; }
  const GridSetup& piece() const { return piece_; }  ///< halo included
  const Box& held() const { return held_; }          ///< of the whole, halo included
  const Box& owned() const { return owned_; }        ///< of the whole

  /// Whether voxel (x, y, z) of the piece is this rank's own.
  bool owns(int x, int y, int z) const;
  /// Whether pixel (u, v) of a face of the piece is one of the whole block's face and this rank's
  /// own.
  bool owns_pixel(Face face, int u, int v) const;

  /// f(cell of the piece, cell of the rank's own), x fastest.
  template <class F>
  void for_own(F f) const {
    const auto first = offset();
    std::size_t own = 0;
    for (int z = 0; z < owned_.extent(2); ++z) {
      for (int y = 0; y < owned_.extent(1); ++y) {
        std::size_t i = piece_.shape.index(first[0], y + first[1], z + first[2]);
        for (int x = 0; x < owned_.extent(0); ++x) f(i++, own++);
      }
    }
  }

  /// Vectors of the whole block, distributed; and of the piece, halo included.
  Vector make_vector() const;
  Vector make_piece() const;
  /// `values` of the piece, the halo's from its owners.
  void read(Vec vector, std::span<double> values) const;
  /// The own part of `values` of the piece.
  void fill(Vec vector, std::span<const double> values) const;
  /// Sets the halo of `values` to what their owners have.
  void exchange(std::span<double> values) const;

  /// Sums over all ranks, in place.
  void sum(std::span<double> values) const;
  double sum(double value) const;

 private:
  /// Of the rank's own box in the piece.
  std::array<int, 3> offset() const;

  MPI_Comm comm_;
  int rank_ = 0, ranks_ = 1;
  GridSetup whole_, piece_;
  Grid grid_;
  Box owned_, held_;
};

}  // namespace kappamu::forward::distributed
