// Which projector pixel each camera pixel sees, as another program found it.
#pragma once

#include <filesystem>

#include "calib/projector/projector_map.h"
#include "capture/session/session.h"

namespace kappamu::calib {

/// From `file`, pixel centres at integers:
///   .npy  float [height][width][2] of the camera's size: projector column and row, NaN where
///         nothing was found
///   .csv  columns x, y, column, row under these names; one line a camera pixel (x, y whole)
/// Throws InputError naming file and line for another size, places outside the frames, and no
/// correspondence at all.
ProjectorMap read_correspondences(const std::filesystem::path& file, const capture::Camera& camera,
                                  const capture::Projector& projector);

}  // namespace kappamu::calib
