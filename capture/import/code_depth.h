// How many bits the codes of photographs have: PNG and TIFF state how codes are stored, not how
// many of the bits the camera fills.
#pragma once

#include <filesystem>
#include <vector>

#include "capture/import/import_photographs.h"
#include "capture/session/session.h"
#include "core/progress.h"

namespace kappamu::capture {

/// Sets `camera.bit_depth`, which is `plan`'s so far, where the photographs contradict it, and
/// warns of that: codes stored with 8 bits, codes that are larger, or codes that end together at
/// the top of fewer bits, where the sensor saturates. Of each stack the longest exposure is read.
/// Photographs are sorted by shot and exposure time; RAW, float and JPEG files tell their depth
/// themselves.
void settle_depth(const std::vector<Photograph>& photographs, const std::filesystem::path& plan,
                  Camera& camera, Progress& progress);

}  // namespace kappamu::capture
