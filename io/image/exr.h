// OpenEXR images of named float channels: "layer.channel", such as "radiance.R" or "variance.R";
// the default layer's channels are plain "R", "G", "B". Single-part scan-line files, 32-bit float.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "io/image/image_limits.h"

namespace kappamu::io {

struct ExrImage {
  int width = 0;                                       ///< [px]
  int height = 0;                                      ///< [px]
  std::map<std::string, std::vector<float>> channels;  ///< [y][x] each, row 0 on top
  std::map<std::string, std::string> attributes;  ///< text attributes, such as units; OpenEXR's
                                                  ///< own come back by OpenImageIO's names
};

/// Half and integer channels are converted to float. Throws InputError naming the file if it is
/// missing, truncated, deep, cropped (data window), or has subsampled channels. `expected`
/// sees the size before anything makes room for it.
ExrImage read_exr(const std::filesystem::path& file, const SizeCheck& expected = {});

/// Lossless (ZIP) compression. Every channel holds width * height values.
void write_exr(const std::filesystem::path& file, const ExrImage& image);

}  // namespace kappamu::io
