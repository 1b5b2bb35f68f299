// HDR merges side by side on a simulated bracket of an eight-bit camera, whose true response all
// are given: error of radiance and time against the number of exposures. OpenCV's merges run in
// the same program on the same frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/subject.h"

namespace kappamu::bench {

struct HdrErrorOptions {
  int width = 320;
  int height = 240;
  int fewest = 2;  ///< exposures, evenly spaced in ln t from 1/30 s to 8 s
  int most = 9;
  int repetitions = 3;  ///< of each merge, for its time
  std::uint64_t seed = 1;
  /// Folder for what other programs need to merge the same: <exposures>_<index>.png, and
  /// response.txt with the linear value of each code, a column per channel.
  std::optional<std::filesystem::path> frames;
};

struct HdrErrorRow {
  std::string method;
  int exposures = 0;
  /// Root mean square of radiance / truth - 1 over four decades of radiance, where the shortest
  /// frame does not saturate; the common factor (median) is taken out, as OpenCV's is arbitrary.
  double relative_rms = 0.0;
  double dark_rms = 0.0;  ///< the same over the darkest decade
  double seconds = 0.0;   ///< of processor time, median of the merge alone
};

std::vector<HdrErrorRow> compare_hdr_merges(const HdrErrorOptions& options, Progress& progress);

Subject hdr_subject();

}  // namespace kappamu::bench
