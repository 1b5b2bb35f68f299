// What one edit does to the voxels of a volume.
#pragma once

#include <cstdint>
#include <vector>

#include "io/volume/volume_set.h"
#include "render/edit/edit.h"
#include "render/edit/edited_body.h"

namespace kappamu::render {

/// One coefficient pair with its standard deviations; those are 0 where the set has none.
struct VoxelValue {
  double kappa = 0.0, mu = 0.0, kappa_std = 0.0, mu_std = 0.0;
};

/// What an edit changes.
struct VoxelDifference {
  struct Change {
    std::uint32_t voxel = 0;
    VoxelValue before, after;
  };
  std::vector<std::vector<Change>> channels;  ///< one list per channel of the set
  std::size_t held = 0;  ///< coefficients that the edit asked beyond the bounds of edit.h

  std::size_t voxels() const;  ///< changed in at least one channel
};

/// `edit` on `set`, which it leaves as it is. Throws InputError naming a channel that the set
/// lacks, a file that cannot be read, numbers that are not one per channel, and as select().
///
/// Standard deviations follow as of a linear map: a product scales them, a sum leaves them, a
/// number that was set has zero, a copy brings its own. Edits of albedo and mean free path keep the
/// ratio of deviation to value, and a set one has zero. Resolution and sensitivity stay those of
/// the measurement.
VoxelDifference difference_of(const Edit& edit, const io::VolumeSet& set,
                              const EditedBody* body = nullptr);

}  // namespace kappamu::render
