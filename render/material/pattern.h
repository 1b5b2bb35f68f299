// Procedural shares: Perlin's noise and what is made of it (K. Perlin, An image synthesizer, 1985;
// Improving noise, 2002).
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "render/scene/scene.h"

namespace kappamu::render {

/// Gradient noise of lattice period 1, in [-1, 1], 0 at the lattice's points, C2.
double gradient_noise(const Eigen::Vector3d& position, std::uint64_t seed);

/// In [0, 1] at a point [mm]:
///   noise   1/2 + f, f being noise summed over octaves, clamped
///   marble  1/2 + sin(2π (x/size + turbulence f))/2, x along `direction`
///   veins   exp(−(f/width)²): 1 on the sheets where the noise is 0
double pattern_at(const Pattern& pattern, const Eigen::Vector3d& point);

}  // namespace kappamu::render
