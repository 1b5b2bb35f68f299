// The uncertainty of a fit as its folder, its volumes and its JSON tell it (docs/formats.md).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "inverse/fit/fit.h"
#include "inverse/uncertainty/uncertainty.h"
#include "io/volume/volume_set.h"

namespace kappamu::pipeline {

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
