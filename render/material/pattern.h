// Procedural shares: Perlin's noise and what is made of it (K. Perlin, An image synthesizer, 1985;
// Improving noise, 2002).
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace kappamu::render {

/// A share in [0, 1] at every point of space.
struct Pattern {
  enum class Kind { noise, marble, veins };

  Kind kind = Kind::noise;
  double size_mm = 1.0;  ///< of the largest structure; of marble, the distance of its bands
  int octaves = 5;       ///< of the noise, each half as large and half as strong
  /// Of marble's bands by noise, in bands [dimensionless].
  double turbulence = 1.0;
  /// Of veins, over the size [dimensionless].
  double width = 0.1;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< across marble's bands
  std::uint64_t seed = 1;
};

/// Gradient noise of lattice period 1, in [-1, 1], 0 at the lattice's points, C2.
double gradient_noise(const Eigen::Vector3d& position, std::uint64_t seed);

/// In [0, 1] at a point [mm]:
///   noise   1/2 + f, f being noise summed over octaves, clamped
///   marble  1/2 + sin(2π (x/size + turbulence f))/2, x along `direction`
///   veins   exp(−(f/width)²): 1 on the sheets where the noise is 0
double pattern_at(const Pattern& pattern, const Eigen::Vector3d& point);

}  // namespace kappamu::render
