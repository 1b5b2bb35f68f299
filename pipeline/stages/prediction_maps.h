// The predicted maps of the seen face as a fit's folder holds them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "core/surface_measurements.h"

namespace kappamu::pipeline {

/// .npy [channels][M][v][u] of the shape of `measurements`.
void write_maps(const std::filesystem::path& file, const SurfaceMeasurements& measurements,
                std::size_t channels, const std::vector<float>& values);

/// `all` with the maps of `patterns` replaced by `part`, one channel's [M][v][u] each.
void put_patterns(std::vector<float>& all, std::size_t cells, const std::vector<int>& patterns,
                  const std::vector<float>& part);

}  // namespace kappamu::pipeline
