// Where the dipole's half-space is not what the object is: sentences for the user.
#pragma once

#include <string>
#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward::dipole {

/// Thickness along the inward normal, measured by rays at up to a thousand triangles, against the
/// mean free path 1/σt' and the diffusion length 1/σ_tr; and absorption beyond diffusion. Empty
/// where all holds.
std::vector<std::string> assumption_warnings(const ObjectProblem& problem);

}  // namespace kappamu::forward::dipole
