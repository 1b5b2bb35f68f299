// OpenEXR images of named float channels: "layer.channel", such as "radiance.R" or "variance.R";
// the default layer's channels are plain "R", "G", "B". Single-part scan-line files, 32-bit float.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/numbers/region.h"
#include "io/image/image_limits.h"

namespace kappamu::io {

/// What an EXR says of itself before its pixels.
struct ExrHeader {
  Region data;     ///< data window: the pixels that the file holds, in those of the picture
  int width = 0;   ///< [px] of the picture: the display window, which begins at (0, 0)
  int height = 0;  ///< [px]
  std::vector<std::string> channels;              ///< in the order of the rows' values
  std::map<std::string, std::string> attributes;  ///< text attributes, such as units; OpenEXR's
                                                  ///< own come back by OpenImageIO's names
  std::vector<std::string> halves{};              ///< channels that a plain file has with 16 bits
};

/// Rows [first, first + rows) of the data window, [row][x][channel].
using TakeExrRows = std::function<void(int first, int rows, const float* values)>;
using FillExrRows = std::function<void(int first, int rows, float* values)>;
/// Sees the header before the rows and gives what takes them.
using OpenExr = std::function<TakeExrRows(const ExrHeader& header)>;
/// Sees the header and says that every so many rows alone are wanted, from the first on: the others
/// are not read where the file is plain.
using ChooseStep = std::function<int(const ExrHeader& header)>;

struct ExrImage {
  int width = 0;                                       ///< [px]
  int height = 0;                                      ///< [px]
  std::map<std::string, std::vector<float>> channels;  ///< [y][x] each, row 0 on top
  std::map<std::string, std::string> attributes;       ///< as in ExrHeader
};

/// Half and integer channels are converted to float. Throws InputError naming the file if it is
/// missing, truncated, deep, has subsampled channels, or a data window beyond its display window.
/// `expected` sees the display window's size before anything makes room for it.
void read_exr_rows(const std::filesystem::path& file, const OpenExr& open,
                   const SizeCheck& expected = {}, const ChooseStep& step = {});

/// The same as a whole; throws InputError for a cropped one too (another data window).
ExrImage read_exr(const std::filesystem::path& file, const SizeCheck& expected = {});

/// Compressed by ZIP (uncompressed: plain_exr.h). `fill` may be asked twice for each row, and must
/// give the same.
void write_exr_rows(const std::filesystem::path& file, const ExrHeader& header,
                    const FillExrRows& fill);

/// ZIP. Every channel holds width * height values.
void write_exr(const std::filesystem::path& file, const ExrImage& image);

}  // namespace kappamu::io
