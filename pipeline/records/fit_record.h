// The head of fit.json: what commands show of a finished fit without reading its volumes.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "pipeline/records/verdict.h"

namespace kappamu::pipeline {

struct FitRecord {
  std::string status;         ///< overall_status() of the channels
  std::array<int, 3> grid{};  ///< nx, ny, nz
  /// Over all channels and validation patterns (core/appearance_error.h); absent without any.
  std::optional<double> validation_E;
  std::optional<double> validation_noise_E;
  std::optional<double> camera_rms_px;  ///< reprojection RMS; absent without a calibration
  std::optional<double> projector_rms_px;
  Verdict verdict;
};

/// Adds the record's keys to `object`.
void add_fit_record(const FitRecord& record, nlohmann::ordered_json& object);

/// Reads `fit`/fit.json. Throws InputError when it is missing or damaged.
FitRecord read_fit_record(const std::filesystem::path& fit);

}  // namespace kappamu::pipeline
