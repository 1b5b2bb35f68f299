// What a fit leaves beside its volumes, as its folder, its volume set and its JSON tell it
// (docs/formats.md): predicted maps of the seen face, sensitivity, uncertainty.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"
#include "inverse/uncertainty/uncertainty.h"
#include "io/volume/volume_set.h"

namespace kappamu::pipeline {

/// .npy [channels][M][v][u] of the shape of `measurements`.
void write_maps(const std::filesystem::path& file, const SurfaceMeasurements& measurements,
                std::size_t channels, const std::vector<float>& values);

/// `all` with the maps of `patterns` replaced by `part`, one channel's [M][v][u] each.
void put_patterns(std::vector<float>& all, std::size_t cells, const std::vector<int>& patterns,
                  const std::vector<float>& part);

/// Writes sensitivity_<channel>.npy, √(sκ² + sμ²): how strongly the data hold a voxel, by either
/// coefficient, and adds it to `volumes`.
void write_sensitivity(const std::filesystem::path& folder, const std::string& channel,
                       const inverse::ChannelFit& fit, io::VolumeSet& volumes);

/// Writes std_kappa_<channel>.npy [mm], std_mu_<channel>.npy [1/mm],
/// resolution_kappa_<channel>.npy, resolution_mu_<channel>.npy and correlation_<channel>.npy,
/// float32 [z][y][x], and adds them to `volumes` (correlation apart), whose last channel is to be
/// this one's. Deviations of κ and μ are those of their logarithms times κ and μ.
void write_uncertainty(const std::filesystem::path& folder, const std::string& channel,
                       const inverse::Uncertainty& uncertainty, const Medium& medium,
                       io::VolumeSet& volumes);

/// Sentence, layers and cost, for fit.json and --json.
nlohmann::ordered_json uncertainty_json(const inverse::UncertaintyReport& report);

}  // namespace kappamu::pipeline
