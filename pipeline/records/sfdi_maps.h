// What `kappamu map` measures: maps of μa and σs' by wavelength, and what was found on the way.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/names.h"
#include "core/shown_text.h"
#include "inverse/lateral/lateral_fit.h"

namespace kappamu::pipeline::sfdi {

/// Value of a pixel that is not valid.
inline constexpr float not_valid = std::numeric_limits<float>::quiet_NaN();

/// Where deviations come from.
enum class Part { noise, detail, pictures, phantom, medium, table };
inline constexpr Names<Part, 6> part_names{{{"noise", Part::noise},
                                            {"detail", Part::detail},
                                            {"pictures", Part::pictures},
                                            {"phantom", Part::phantom},
                                            {"medium", Part::medium},
                                            {"table", Part::table}}};

/// What was found in the pictures of one spatial frequency.
struct LightCheck {
  double per_mm = 0.0;
  std::optional<double> found_per_mm;
  double second_harmonic = 0.0, stripes = 0.0;  ///< over the amplitude
  std::size_t saturated = 0;
  std::optional<double> shift_mm;  ///< median, of the fringes against the phantom's
};

/// Mean over region_px.
struct RegionMean {
  std::size_t pixels = 0;
  inverse::LateralCoefficients mean;
  std::array<double, 2> deviation{};  ///< standard, of the mean [1/mm]: μa, σs'
  std::array<double, 2> spread{};     ///< standard deviation over pixels [1/mm]
};

/// Both layers of a region, where neither is known. Deviations of the logarithms and whether the
/// light tells them: μa and σs' of the upper layer, then of the lower one.
struct TwoLayers {
  inverse::LateralCoefficients upper, lower;  ///< [1/mm]
  std::array<double, 4> relative_deviation{};
  std::array<bool, 4> determined{};
  double chi_square = 0.0;
  bool converged = false;
  double thickness_mm = 0.0;  ///< of the upper one
};

struct WavelengthMap {
  double wavelength_nm = 0.0;
  std::string name;                            ///< of a camera's channel instead, "R"; else empty
  Image<float> mua, musp;                      ///< [1/mm]; not a number where not valid
  Image<float> mua_deviation, musp_deviation;  ///< standard [1/mm]
  Image<float> kappa, kappa_deviation;         ///< κ = 1/(3(μa + σs')) [mm]
  Image<float> height_mm;                      ///< above the phantom's plane; empty: not measured
  Image<std::uint8_t> verdict;                 ///< inverse::LateralVerdict; 0: valid
  std::array<std::array<double, 2>, part_names.size()> parts{};  ///< median, relative: μa, σs'
  std::vector<LightCheck> checks;
  std::optional<RegionMean> region;
  std::optional<TwoLayers> layers;

  /// "660 nm", or "R": in sentences.
  std::string label() const { return name.empty() ? shown_number(wavelength_nm) + " nm" : name; }
  /// "nm660", or "R": in names of channels.
  std::string key() const { return name.empty() ? "nm" + shown_number(wavelength_nm) : name; }
};

/// A quantity by pixel that all wavelengths together give; not a number where one is not valid.
struct SpectralMap {
  std::string name;  ///< of its files: "hbo2", "saturation", "scattering_500nm", ...
  std::string unit;  ///< "" of a ratio
  Image<float> value, deviation;
};

struct Maps {
  std::vector<WavelengthMap> wavelengths;
  std::vector<SpectralMap> spectral;
  std::optional<double> chi_square;  ///< of the absorbers: median per degree of freedom
  std::vector<std::string> warnings;
};

}  // namespace kappamu::pipeline::sfdi
