#include "pipeline/stages/prediction_maps.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "io/npy.h"

namespace kappamu::pipeline {

void write_maps(const std::filesystem::path& file, const SurfaceMeasurements& measurements,
                std::size_t channels, const std::vector<float>& values) {
  const FaceShape face = measurements.seen_shape();
  io::write_npy(file,
                {channels, static_cast<std::size_t>(measurements.patterns),
                 static_cast<std::size_t>(face.nv), static_cast<std::size_t>(face.nu)},
                std::span<const float>(values));
}

void put_patterns(std::vector<float>& all, std::size_t cells, const std::vector<int>& patterns,
                  const std::vector<float>& part) {
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    std::copy_n(
        part.begin() + static_cast<std::ptrdiff_t>(k * cells), cells,
        all.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(patterns[k]) * cells));
  }
}

}  // namespace kappamu::pipeline
