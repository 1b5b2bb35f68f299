// A volume whose extents all differ and whose every coefficient differs in one voxel: axes swapped,
// flipped or shifted by half a voxel move the marker.
#pragma once

#include "io/volume/volume_set.h"

namespace kappamu::io {

inline Volume<double> with_marker(double background, double marker, int x, int y, int z) {
  Volume<double> volume(GridShape{5, 3, 4, 0.25}, background);
  volume(x, y, z) = marker;
  return volume;
}

/// Channels R and G. Markers: κ of R at (4, 1, 2), of G at (0, 2, 3); μ at (1, 0, 3) and (3, 1, 0).
/// σt' = 1/(3κ), albedo = 1 − 3κμ would have two markers each, so κ and μ do not differ together.
inline VolumeSet marker_set() {
  VolumeSet set;
  set.channels = {"R", "G"};
  set.media = {{with_marker(0.2, 0.5, 4, 1, 2), with_marker(0.01, 0.02, 1, 0, 3)},
               {with_marker(0.1, 0.4, 0, 2, 3), with_marker(0.0, 0.03, 3, 1, 0)}};
  set.eta = 1.45;
  set.metadata = {{"session", "demo <a&b>"}, {"version", "0.1.0"}};
  return set;
}

}  // namespace kappamu::io
