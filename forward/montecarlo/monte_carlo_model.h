// Radiative transfer by Monte Carlo behind the common interface of forward models: the referee of
// what diffusion claims.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "forward/forward_model.h"

namespace kappamu::forward {

/// Needs an OpenCL device. `photons`, `anisotropy`, `seed` and `device` of the options concern it;
/// exitance maps come with standard errors (a pixel no photon reached has mean 0 and the standard
/// error that one photon of full weight would make), and `unscattered` is all light of a collimated
/// beam that leaves by any face without a collision. Under the boundary source light enters
/// Lambertian inside, T·E, and nothing counts as unscattered.
std::unique_ptr<ForwardModel> make_monte_carlo_model();

/// Standard error of the mean of `exitance` over pixels, which is less than what the pixels' own
/// would give if they were independent: a photon that leaves by one does not leave by another.
/// `entering` is the pattern's PowerBalance::entering, `pixel_area` h². [unit of exitance]
double standard_error_of_mean(std::span<const double> exitance,
                              std::span<const double> standard_error, double entering,
                              double pixel_area, std::uint64_t photons);

}  // namespace kappamu::forward
