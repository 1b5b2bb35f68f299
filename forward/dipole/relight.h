// A homogeneous object whose light, shape and material change: the dipole with sources placed
// reciprocally, its hierarchy and links kept between lights ([M]'s static mode), shapes and
// materials (incremental), three colour channels in one sum.
#pragma once

#include <memory>

#include "forward/live_model.h"

namespace kappamu::forward::dipole {

/// Throws InputError for a medium that varies. The error it measures is the summation's, the worst
/// channel's, at a few triangles against the direct sum; that takes longer than the sum itself.
std::unique_ptr<LiveModel> make_relight(const LiveBody& object, const ObjectOptions& options);

}  // namespace kappamu::forward::dipole
