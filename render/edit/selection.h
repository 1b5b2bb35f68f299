// The voxels that a selection names.
#pragma once

#include <cstdint>
#include <vector>

#include "render/edit/edit.h"

namespace kappamu::render {

struct SelectedVoxel {
  std::uint32_t voxel = 0;  ///< GridShape::index
  double weight = 0.0;      ///< in (0, 1]
};

/// In the order of their indices. Throws InputError naming an image that cannot be read, or when
/// strokes are more than 250,000 radii long.
std::vector<SelectedVoxel> select(const Selection& where, const GridShape& shape);

}  // namespace kappamu::render
