#pragma once

/// What blocks are expected to be before their data are seen: shared by the homogeneous start, the
/// layers and the check of scale and shift.
namespace kappamu::inverse {

/// Expected share of collisions that absorb, 3κμ, and the spread of its logarithm: marble, milk,
/// wax, skin and juices lie within two spreads (Jensen et al. 2001, table 1).
inline constexpr double expected_absorption = 3e-3;
inline constexpr double absorption_spread = 2.0;
/// Spread of log κ and log μ between neighbouring layers.
inline constexpr double layer_spread = 1.0;
/// Vanishing predictions count as this share of the datum.
inline constexpr double darkest_ratio = 1e-6;

}  // namespace kappamu::inverse
