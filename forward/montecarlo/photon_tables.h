// What photons look up on their way, made on the host: each voxel's chances at a tentative
// collision, and where to enter. Chances are 32-bit integers in units of 2^-32, 0xFFFFFFFF being
// certainty.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/grid.h"

namespace kappamu::forward {

struct VoxelChances {
  std::uint32_t real = 0;      ///< σt / majorant: the collision is real, not a fictitious one
  std::uint32_t absorbed = 0;  ///< σa / σt: a real one absorbs
};

struct CollisionTable {
  double majorant = 0.0;             ///< largest σt = μ + σs'/(1−g) of the volume [1/mm]
  double mean = 0.0;                 ///< of σt over all voxels [1/mm]
  std::vector<VoxelChances> voxels;  ///< [z][y][x]
};

/// σs = (1/(3κ) − μ)/(1−g). Throws InputError naming the first voxel where κ and μ leave no
/// scattering (3κμ > 1, beyond the rounding of single precision), and unless −1 < g < 1.
CollisionTable collision_table(const Medium& medium, double anisotropy);

/// Walker's alias method (1977): draw a pixel evenly, keep it when a second draw is below
/// `keep`, else take `other`. Chances are right to 2^-32 of the mean pixel's.
struct AliasEntry {
  std::uint32_t keep = 0xFFFFFFFF;
  std::uint32_t other = 0;
};

/// For weights that are not negative and not all zero.
std::vector<AliasEntry> alias_table(std::span<const double> weights);

}  // namespace kappamu::forward
