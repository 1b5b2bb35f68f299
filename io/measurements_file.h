// SurfaceMeasurements as a folder: measurements.json and NumPy arrays (docs/formats.md, "Surface
// measurements").
#pragma once

#include <filesystem>
#include <string>

#include "core/surface_measurements.h"

namespace kappamu::io {

/// Throws InputError naming file and field if a field is missing, unknown or wrong, or an array has
/// another shape than measurements.json says; what it returns passes validate().
SurfaceMeasurements read_measurements(const std::filesystem::path& folder);

/// measurements.json alone: no arrays, and how many patterns there are is not known.
SurfaceMeasurements read_measurements_header(const std::filesystem::path& folder);

/// Validates, then writes; measurements.json comes last, so a folder that has one is complete.
/// `smooth_error_source` says where smooth_error comes from, for the reader.
void write_measurements(const std::filesystem::path& folder,
                        const SurfaceMeasurements& measurements,
                        const std::string& smooth_error_source = "");

}  // namespace kappamu::io
