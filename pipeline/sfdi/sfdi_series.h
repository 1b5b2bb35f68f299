// Measurements whose pictures' names follow a rule, as instruments write them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// Each wavelength under each frequency. Of even light those phases count whose files exist, since
/// instruments take one or all of them. `file` is the description's, for sentences. Throws
/// InputError naming the field for a placeholder that is not known or missing.
std::vector<Pictures> pictures_of(const Series& series, const std::filesystem::path& folder,
                                  const std::string& file);

}  // namespace kappamu::pipeline::sfdi
