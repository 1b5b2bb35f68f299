// NumPy arrays that no rank holds whole: each reads and writes its part by MPI-IO. Every function
// is called by all ranks and fails on all.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "forward/distributed/block_pieces.h"

namespace kappamu::app::mpi {

/// A box of an array of `shape`, slowest axis first.
struct Part {
  std::vector<std::size_t> shape, begin, count;

  std::size_t size() const;
};

/// Of a volume [z][y][x].
Part volume_part(const GridShape& whole, const forward::distributed::Box& box);
/// Of maps [patterns][v][u] of a face, the pixels that `box` has beside it; of none where
/// `touching` is asked and it does not touch the face.
Part face_part(const GridShape& whole, Face face, int patterns,
               const forward::distributed::Box& box, bool touching = false);
/// With an axis in front of which the part has the `index`-th of `count`.
Part within(Part part, std::size_t index, std::size_t count);

/// The shape of the array in `file`.
std::vector<std::size_t> npy_shape(MPI_Comm comm, const std::filesystem::path& file);

/// float32, float64 or uint8. Throws InputError naming the file and both shapes where they differ.
std::vector<double> read_part(MPI_Comm comm, const std::filesystem::path& file, const Part& part);

/// Writes into a file of that shape, which the first call for it makes.
void write_part(MPI_Comm comm, const std::filesystem::path& file, const Part& part,
                std::span<const float> values);
void write_part(MPI_Comm comm, const std::filesystem::path& file, const Part& part,
                std::span<const double> values);

}  // namespace kappamu::app::mpi
