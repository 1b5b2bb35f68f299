// A block cut between the ranks of MPI: each owns the columns along the light of a rectangle of the
// lit face, so that a beam never leaves its rank.
//
// The piece of a rank is what it owns and, towards each neighbour, a halo one voxel wide, corners
// included: a smaller block of its own, whose arrays are [z][y][x] as any block's. Every rank of
// the communicator makes the same calls in the same order.
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
  /// Cut so that voxels of twice the edge, `halvings` times over, nest on their rank; fewer times
  /// where a rank would have less than two of them along an axis that is cut. Throws InputError, on
  /// every rank, where the block has fewer columns than there are ranks.
  BlockPieces(MPI_Comm comm, const GridSetup& whole, int halvings = 0);

  /// The block in voxels of twice the edge, odd extents rounded up, each on the rank of what it is
  /// made of. Only where halvings() is above 0.
  std::shared_ptr<const BlockPieces> coarser() const;
  /// The block `whole` in voxels of half the edge, cut in the same places. Its piece is this one
  /// with every voxel split, so that the halo is two voxels wide; extents that were rounded up end
  /// where `whole` does.
  std::shared_ptr<const BlockPieces> split(const GridSetup& whole) const;
  int halvings() const { return halvings_; }

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  /// That vectors and matrices are made of.
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

  /// A vector of the whole block, distributed.
  Vector make_vector() const;
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
  /// Voxels of each rank along each axis.
  using Lengths = std::array<std::vector<PetscInt>, 3>;
  BlockPieces(MPI_Comm comm, const GridSetup& whole, Lengths lengths, int halo);
  void cut(int halo);

  /// Of the rank's own box in the piece.
  std::array<int, 3> offset() const;

  MPI_Comm comm_;
  int rank_ = 0, ranks_ = 1;
  int halvings_ = 0;
  GridSetup whole_, piece_;
  Lengths lengths_;
  Grid grid_;  ///< neighbours across faces, which are all that a matrix needs
  Grid halo_;  ///< and across edges
  Box owned_, held_;
};

}  // namespace kappamu::forward::distributed
