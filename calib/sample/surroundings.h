// The part of the camera's picture that shows a sample: what else a photograph shows need not be
// merged.
#pragma once

#include "calib/lens/lens.h"
#include "core/grid.h"
#include "core/numbers/region.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// Adds the eight corners of the block.
void add_block(const Lens& camera, const Rigid& camera_from_sample, const GridShape& grid,
               Surrounding& surrounding);

/// With a quarter of its extent around it, and 64 px at least: room for a sample that moved
/// between photographs, and for light that falls beside it. Its edges are as
/// capture::MergeOptions::part wants them.
Region with_surroundings(const Surrounding& surrounding, const Lens& camera);

}  // namespace kappamu::calib
