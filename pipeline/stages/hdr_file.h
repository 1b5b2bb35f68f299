// HDR images of a run: hdr/<pattern>.exr with channels R, G, B (radiance, full scales/s),
// variance.R ... (its square) and flags.R ... (capture::PixelFlag bits as whole numbers).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/radiance/hdr.h"

namespace kappamu::pipeline {

/// Writes by rename. `channels` names the image's channels in order; `notes` are what merging its
/// frames had to note, a line each, for who finds the file later.
void write_hdr(const std::filesystem::path& file, const capture::HdrImage& image,
               const std::vector<std::string>& channels, const std::vector<std::string>& notes);

/// Of write_hdr().
std::vector<std::string> read_hdr_notes(const std::filesystem::path& file);

/// Throws InputError naming file and channel when something is missing.
capture::HdrImage read_hdr(const std::filesystem::path& file,
                           const std::vector<std::string>& channels);

}  // namespace kappamu::pipeline
