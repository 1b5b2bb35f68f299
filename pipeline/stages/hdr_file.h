// HDR images of a run: hdr/<pattern>.exr with channels R, G, B (radiance, full scales/s),
// variance.R ... (its square) and flags.R ... (capture::PixelFlag bits as whole numbers).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/radiance/hdr.h"
#include "capture/session/session.h"

namespace kappamu::pipeline {

/// Writes by rename, with the session's channels; an image that is a part of the camera's picture
/// lies there as the data window in the display window. `notes` are what merging its frames had to
/// note, a line each, for who finds the file later. Returns the file's ContentFingerprint.
std::string write_hdr(const std::filesystem::path& file, const capture::HdrImage& image,
                      const capture::Session& session, const std::vector<std::string>& notes);

/// What write_hdr() wrote, `notes` with it where they are asked for. Throws InputError naming file
/// and channel when something is missing.
capture::HdrImage read_hdr(const std::filesystem::path& file,
                           const std::vector<std::string>& channels,
                           std::vector<std::string>* notes = nullptr);

}  // namespace kappamu::pipeline
