// Whether diffusion is accurate enough for a block: whether transport finds nearly the same
// homogeneous block in the data. The error of diffusion's light is no criterion: on structured
// blocks 3.5 mean free paths thick it is 1 %, that of κ 40 % (studies/notes/fit-choices.md).
#pragma once

#include <string>

#include "inverse/block_model/homogeneous.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

struct PhysicsChoice {
  Physics physics = Physics::diffusion;
  std::string reason;  ///< one sentence
  SolveCount solves;
};

/// Fits the best homogeneous block by diffusion and by transport to four patterns of `problem` on
/// the finest grid, from the homogeneous `start` by diffusion. Transport's r has 15 % of noise in a
/// pixel. Transport is chosen if the blocks differ by more than 5 % of κ or 15 % of μ, and by more
/// than half of the start's standard deviations.
PhysicsChoice choose_physics(const Problem& problem, const HomogeneousFit& start,
                             const Backend& backend, PhotonOptions photons);

}  // namespace kappamu::inverse
