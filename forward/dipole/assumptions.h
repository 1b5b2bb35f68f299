// Where the dipole's half-space is not what the object is: sentences for the user.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward::dipole {

/// Thickness along the inward normal, measured by rays at up to a thousand triangles, against the
/// mean free path 1/σt' and the diffusion length 1/σ_tr; and absorption beyond diffusion. Empty
/// where all holds.
std::vector<std::string> assumption_warnings(const ObjectProblem& problem);

/// Of sources along the normal alone: one that lies a mean free path below its own triangle but
/// nearer to another part of the surface lights it by up to the inverse square of that distance,
/// more than any half-space does. None where there is no such source.
std::optional<std::string> aligned_source_warning(const ObjectProblem& problem);

}  // namespace kappamu::forward::dipole
