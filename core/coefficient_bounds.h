// Which coefficients of diffusion are taken for those of a material.
#pragma once

namespace kappamu {

/// κ [mm] lies between the two, μ [1/mm] below the second. Beyond, squares leave the range of
/// floats, and light that scatters 1e9 times in a millimetre is followed for ever.
inline constexpr double least_kappa = 1e-9, most_coefficient = 1e9;

}  // namespace kappamu
