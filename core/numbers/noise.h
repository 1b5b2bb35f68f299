// Smooth procedural noise in space, deterministic by seed.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace kappamu {

/// Value noise (lattice of uniform numbers, quintic blending, so C2): roughly in [-1, 1], lattice
/// period 1.
double value_noise(const Eigen::Vector3d& position, std::uint64_t seed);

/// Sum of `octaves` value noises, each half the size and half the weight of the one before it;
/// roughly in [-1, 1]. `size` is the lattice period of the largest [unit of position].
double layered_noise(const Eigen::Vector3d& position, double size, int octaves, std::uint64_t seed);

}  // namespace kappamu
