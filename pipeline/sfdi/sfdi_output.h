// The files of `kappamu map`: arrays, an EXR of all of them, and summary.json.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// Names of what write_maps() puts into a folder.
std::vector<std::string> map_files(const Description& description);

/// mua.npy, musp.npy, kappa.npy and their _deviation.npy, float32 [wavelength][y][x], not a number
/// where not valid; verdict.npy, uint8, 0 where valid; maps.exr with channels such as "nm660.mua".
/// Maps of all wavelengths together are [y][x], "spectral.hbo2" in maps.exr.
void write_maps(const Maps& maps, const std::filesystem::path& folder);

/// What summary.json holds: medians, parts of the deviations, counts of pixels by verdict, checks.
nlohmann::ordered_json summary_of(const Maps& maps, const Description& description, double seconds);

}  // namespace kappamu::pipeline::sfdi
