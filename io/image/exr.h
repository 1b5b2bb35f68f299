// OpenEXR images of named float channels: "layer.channel", such as "radiance.R" or "variance.R";
// the default layer's channels are plain "R", "G", "B". Single-part scan-line files, 32-bit float.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace kappamu::io {

struct ExrImage {
  int width = 0;                                       ///< [px]
  int height = 0;                                      ///< [px]
  std::map<std::string, std::vector<float>> channels;  ///< [y][x] each, row 0 on top
  std::map<std::string, std::string> attributes;       ///< text attributes, such as units
};

/// Half and integer channels are converted to float. Throws InputError naming the file if it is
/// missing, truncated, or not a scan-line or tiled EXR image with unsubsampled channels.
ExrImage read_exr(const std::filesystem::path& file);

/// Lossless (ZIP) compression. Every channel holds width * height values.
void write_exr(const std::filesystem::path& file, const ExrImage& image);

}  // namespace kappamu::io
