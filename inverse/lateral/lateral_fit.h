// μa and σs' of a homogeneous medium from its reflectance at two or more spatial frequencies: at
// each pixel of a map by itself, neighbours do not matter.
#pragma once

#include <Eigen/Core>
#include <bitset>
#include <optional>

#include "core/names.h"
#include "forward/lateral/lateral_reflectance.h"

namespace kappamu::inverse {

inline constexpr int most_frequencies = 16;
/// One number per spatial frequency.
using PerFrequency = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_frequencies, 1>;
using Gain = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, most_frequencies>;

/// Which of them are seen from a slab's far side.
using FarSides = std::bitset<most_frequencies>;

enum class LateralVerdict {
  good,
  no_light,       ///< no pixel value, saturated, or a reflectance that is not positive
  no_medium,      ///< no coefficients have these reflectances, as at glare and at edges
  outside_table,  ///< the transport table does not reach the coefficients
};
inline constexpr Names<LateralVerdict, 4> lateral_verdict_names{
    {{"good", LateralVerdict::good},
     {"no_light", LateralVerdict::no_light},
     {"no_medium", LateralVerdict::no_medium},
     {"outside_table", LateralVerdict::outside_table}}};

struct LateralCoefficients {
  double mua = 0.02;  ///< μa [1/mm]
  double musp = 1.0;  ///< σs' [1/mm]
};

struct LateralFit {
  LateralVerdict verdict = LateralVerdict::no_medium;
  LateralCoefficients coefficients;
  Gain gain;                ///< ∂(ln μa, ln σs')/∂ ln R of each frequency
  double chi_square = 0.0;  ///< Σ (residual/deviation)²; 0 for two frequencies
};

/// Weighted least squares in logarithms by Gauss-Newton. `reflectance` and `deviation` (standard,
/// relative, > 0) per frequency [1/mm]; a frequency may be there twice, from both sides.
LateralFit fit_lateral(const forward::LateralReflectance& model, const PerFrequency& frequency,
                       const PerFrequency& reflectance, const PerFrequency& deviation,
                       const LateralCoefficients& start, const FarSides& far = {});

/// Reflectance, or transmittance where the side is the far one.
inline forward::LateralValue seen(const forward::LateralReflectance& model, bool far,
                                  double frequency, double mua, double musp) {
  return far ? model.transmittance(frequency, mua, musp) : model(frequency, mua, musp);
}

}  // namespace kappamu::inverse
