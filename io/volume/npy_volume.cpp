#include "io/volume/npy_volume.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/error.h"
#include "io/npy.h"
#include "io/volume/volume_file.h"

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

Volume<double> read_npy_volume(const std::filesystem::path& file, double voxel_mm,
                               std::size_t most_voxels) {
  GridShape shape;
  const NpyArray array = read_npy(file, [&](const std::vector<std::size_t>& found) {
    const auto fits = [](std::size_t n) { return n >= 1 && n <= std::size_t{1} << 16; };
    if (found.size() != 3 || !std::all_of(found.begin(), found.end(), fits)) {
      throw InputError(file.string() + ": shape " + shape_to_string(found) +
                       " is not that of a volume [z][y][x] with up to 65536 voxels a side");
    }
    shape = {static_cast<int>(found[2]), static_cast<int>(found[1]), static_cast<int>(found[0]),
             voxel_mm};
    check_voxels(file, shape, 1, most_voxels);
  });
  return to_volume(shape, array);
}

void write_npy_volume(const std::filesystem::path& file, const Volume<double>& volume) {
  const std::vector<float> values(volume.values().begin(), volume.values().end());
  write_npy(file, array_shape(volume.shape()), std::span<const float>(values));
}

}  // namespace kappamu::io
