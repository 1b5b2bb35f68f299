#include "io/volume/npy_volume.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/error.h"
#include "io/npy.h"

namespace kappamu::io {

namespace {

std::vector<std::size_t> array_shape(const GridShape& shape) {
  return {static_cast<std::size_t>(shape.nz), static_cast<std::size_t>(shape.ny),
          static_cast<std::size_t>(shape.nx)};
}

Volume<double> to_volume(const GridShape& shape, const NpyArray& array) {
  return {shape, std::vector<double>(array.values.begin(), array.values.end())};
}

}  // namespace

Volume<double> read_npy_volume(const std::filesystem::path& file, const GridShape& shape) {
  return to_volume(shape, read_npy(file, array_shape(shape)));
}

Volume<double> read_npy_volume(const std::filesystem::path& file, double voxel_mm) {
  const NpyArray array = read_npy(file);
  const auto fits = [](std::size_t n) {
    return n >= 1 && n <= static_cast<std::size_t>(std::numeric_limits<int>::max());
  };
  if (array.shape.size() != 3 || !std::all_of(array.shape.begin(), array.shape.end(), fits)) {
    throw InputError(file.string() + ": shape " + shape_to_string(array.shape) +
                     " is not that of a volume [z][y][x]");
  }
  return to_volume({static_cast<int>(array.shape[2]), static_cast<int>(array.shape[1]),
                    static_cast<int>(array.shape[0]), voxel_mm},
                   array);
}

void write_npy_volume(const std::filesystem::path& file, const Volume<double>& volume) {
  const std::vector<float> values(volume.values().begin(), volume.values().end());
  write_npy(file, array_shape(volume.shape()), std::span<const float>(values));
}

}  // namespace kappamu::io
