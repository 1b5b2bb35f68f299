// The maps of `kappamu map` as a picture and as a page.
#pragma once

#include <filesystem>

#include "pipeline/records/sfdi_maps.h"

namespace kappamu::report {

/// maps.png: of each wavelength μa and σs' side by side, grey where not valid.
void write_map_picture(const pipeline::sfdi::Maps& maps, const std::filesystem::path& file);

/// maps.html, self-contained: maps with scales, deviations, parts, checks and warnings.
void write_map_page(const pipeline::sfdi::Maps& maps, const std::filesystem::path& file);

}  // namespace kappamu::report
