// Where the light of each pattern went. Powers are in mm² times the irradiance's unit.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/grid.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Under the physical convention entering = Σ exiting + unscattered + absorbed, to solver
/// tolerance. Under wang2008 `exiting` sums π·L, which is no flux, and nothing balances.
struct PowerBalance {
  double entering = 0.0;            ///< transmitted through the lit face: T·E integrated over it
  std::array<double, 6> exiting{};  ///< exitance integrated over each face, in order of all_faces
  double unscattered = 0.0;         ///< of the beam, leaving without a collision
  double absorbed = 0.0;  ///< μφ integrated over the block, plus first collisions absorbed
};

/// One balance per pattern; exitance maps, as GridSolver::exitance gives them, in order of
/// all_faces.
std::vector<PowerBalance> power_balance(const GridSolver& solver, const Medium& medium,
                                        const BatchField& phi, std::span<const double> irradiance,
                                        const std::array<std::vector<double>, 6>& exitance);

}  // namespace kappamu::forward
