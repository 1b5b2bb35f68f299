#include "io/volume/scattering_export.h"

#include <array>
#include <charconv>

namespace kappamu::io {

std::vector<ScatteringVolumes> scattering_with_warnings(const VolumeSet& set,
                                                        ExportResult& result) {
  std::vector<ScatteringVolumes> volumes;
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    volumes.push_back(scattering_volumes(set.media[c]));
    if (volumes.back().clamped == 0) continue;
    result.warnings.push_back("channel " + set.channels[c] + ": " +
                              std::to_string(volumes.back().clamped) + " of " +
                              std::to_string(set.shape().cells()) +
                              " voxels have 3 kappa mu >= 1, where no scattering is left; their "
                              "albedo was set to 0");
  }
  return volumes;
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

}  // namespace kappamu::io
