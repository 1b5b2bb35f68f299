// A camera's lens known from elsewhere, as a start of a calibration or held in it.
#pragma once

#include <filesystem>

#include "calib/lens/lens.h"

namespace kappamu::calib {

enum class LensUse {
  start,  ///< all its numbers are estimated anew
  held    ///< taken as exact
};

struct KnownLens {
  Lens lens;  ///< width and height 0 where the file does not state them
  LensUse use = LensUse::held;
  std::filesystem::path file;  ///< for messages
};

/// Reads a camera matrix and distortion coefficients (OpenCV's order, up to k6) from YAML as
/// OpenCV, ROS and kappamu (camera.yml) write it or from JSON, under the names in use for them,
/// matrices as OpenCV's or as lists. Throws InputError naming the file for fields that are missing,
/// numbers of no lens, and models that OpenCV's eight coefficients do not hold (fisheye, thin
/// prism, tilt).
KnownLens read_known_lens(const std::filesystem::path& file, LensUse use);

/// Throws InputError where the lens is of pictures of another size.
void require_size(const KnownLens& known, int width, int height);

}  // namespace kappamu::calib
