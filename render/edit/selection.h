// The voxels that a selection names.
#pragma once

#include <cstdint>
#include <vector>

#include "render/edit/edit.h"
#include "render/edit/edited_body.h"

namespace kappamu::render {

struct SelectedVoxel {
  std::uint32_t voxel = 0;  ///< GridShape::index
  double weight = 0.0;      ///< in (0, 1]
};

/// In the order of their indices. `body` holds the volume; none: the volume is by itself. Throws
/// InputError naming an image that cannot be read, when strokes are more than 250,000 radii long,
/// or for a place of the object's frame where there is no object.
std::vector<SelectedVoxel> select(const Selection& where, const GridShape& shape,
                                  const EditedBody* body = nullptr);

}  // namespace kappamu::render
