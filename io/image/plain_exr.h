// EXR files without compression, written and read row by row: what a merge writes and a report
// looks into may be larger than memory allows as a whole (OpenEXR file layout, version 2, scan
// lines of one part).
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "io/image/exr.h"

namespace kappamu::io {

/// Writes one channel, counted as the header's, of row `y` of the data window.
using FillExrChannel = std::function<void(int y, std::size_t channel, float* values)>;
/// Sees the file's bytes as they are written.
using WatchBytes = std::function<void(std::span<const char>)>;
/// Pictures with noise become little smaller by compression, which takes many times as long as
/// their photographs' decoding.
void write_plain_exr(const std::filesystem::path& file, const ExrHeader& header,
                     const FillExrChannel& fill, const WatchBytes& watch = {});

class PlainExrFile {
 public:
  /// Nothing of a file that is not laid out as write_plain_exr() does: OpenEXR's reader may take
  /// it.
  static std::optional<PlainExrFile> open(const std::filesystem::path& file);

  const ExrHeader& header() const { return header_; }
  /// Row `y` of the data window, [x][channel]. False where the file is damaged.
  bool read(int y, float* values);

 private:
  std::ifstream in_;
  ExrHeader header_;
  std::vector<std::uint64_t> places_;  ///< of the rows
  std::vector<char> row_;
};

}  // namespace kappamu::io
