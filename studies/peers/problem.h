// The assembled problem as `kappamu-studies` hands it to the peers, and a rank's part of it.
//
// Folder (doubles and ints of this machine): problem.txt holds "nx ny nz patterns"; link_x.bin,
// link_y.bin, link_z.bin [z][y][x] the conductance G from each cell to its neighbour towards +x,
// +y, +z (0 at the last cell); diagonal.bin [z][y][x]; rhs.bin [pattern][z][y][x].
//     (A φ)_i = d_i φ_i − Σ_j G_ij φ_j = b_i
// The peers see axes (x, m, s), s the longer of y and z: ranks own slabs across s, which keeps what
// they exchange small; rows are numbered with s slowest, so that every rank's rows are contiguous
// and the band is narrow.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

namespace kappamu::peers {

class Problem {
 public:
  /// Reads the folder and takes rank's slab of `ranks`. Throws std::runtime_error naming the file.
  Problem(const std::filesystem::path& folder, int rank, int ranks);

  int rows() const { return extent_[0] * extent_[1] * extent_[2]; }
  int patterns() const { return patterns_; }
  int first_row() const { return slab_begin_ * plane(); }
  int local_rows() const { return (slab_end_ - slab_begin_) * plane(); }

  /// The slab as a box of cells in (x, m, s), both ends included; rows run through it x fastest.
  std::array<int, 3> lower() const { return {0, 0, slab_begin_}; }
  std::array<int, 3> upper() const { return {extent_[0] - 1, extent_[1] - 1, slab_end_ - 1}; }

  /// Of row first_row() + local the centre, +x, +m, +s; 0 towards the outside.
  std::array<double, 4> upper_row(int local) const;

  std::vector<double> local_rhs(int pattern) const;  ///< in row order
  /// Index in [z][y][x] of a row of any rank.
  std::size_t cell(int row) const { return index(position(row)); }

 private:
  int plane() const { return extent_[0] * extent_[1]; }
  std::array<int, 3> position(int row) const;
  std::size_t index(const std::array<int, 3>& position) const;

  std::array<int, 3> extent_{};              ///< of (x, m, s)
  std::array<std::size_t, 3> stride_{};      ///< of (x, m, s) in [z][y][x]
  std::array<std::vector<double>, 3> link_;  ///< towards +x, +m, +s
  std::vector<double> diagonal_, rhs_;
  int patterns_ = 0;
  int slab_begin_ = 0, slab_end_ = 0;
};

}  // namespace kappamu::peers
