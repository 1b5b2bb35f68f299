// sfdi.json: what the pictures of a spatial frequency domain measurement show (docs/sfdi.md has the
// fields). Any lab writes it by hand beside its pictures, or lets a script.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kappamu::pipeline::sfdi {

inline constexpr const char* file_name = "sfdi.json";

/// Standard deviation of the Gaussian that averages what is demodulated pixel by pixel. Light mixes
/// over a transport mean free path, 0.5 to 2 mm: detail below is noise and texture of the surface.
inline constexpr double usual_smoothing_mm = 0.5;

struct Medium {
  double refractive_index = 1.4;
  std::optional<double> refractive_index_deviation;  ///< standard; absent: exactly known
  double anisotropy = 0.9;                           ///< g
  std::optional<double> anisotropy_deviation;        ///< standard; absent: exactly known
  std::optional<double> thickness_mm;                ///< of a slab; absent: half-space
};

/// A reference phantom at one wavelength.
struct PhantomRow {
  double wavelength_nm = 0.0;
  double absorption_per_mm = 0.0;          ///< μa
  double reduced_scattering_per_mm = 0.0;  ///< σs'
  /// Standard deviations of both over both; absent: exactly known.
  std::optional<std::array<double, 2>> relative_deviation;
};

struct Reference {
  std::vector<PhantomRow> coefficients;  ///< by wavelength, linear in between
  /// x, y, width, height [px]: its mean here stands for every pixel. Absent: pixel by pixel.
  std::optional<std::array<int, 4>> region_px;
  std::optional<double> thickness_mm;  ///< absent: half-space
};

/// Relative standard deviations of what neighbouring pixels share.
struct Errors {
  double common = 0.0;  ///< of all pictures of one object alike
  double own = 0.0;     ///< of each spatial frequency by itself
};

/// Where the projector stands; the camera looks straight down at the picture's centre.
struct ProjectorPlace {
  double degrees = 0.0;  ///< from the camera's axis in the direction of the sinusoids' change
  double distance_mm = 0.0;
};

/// One wavelength under one sinusoid, or under even light.
struct Pictures {
  double wavelength_nm = 0.0;
  double per_mm = 0.0;                      ///< spatial frequency; 0: even light
  std::optional<double> direction_degrees;  ///< of change, from x towards y; absent: 0
  /// Files. `reference` is empty without a phantom, and may be for even light: the phantom's mean
  /// under the first sinusoid stands for it.
  std::vector<std::string> sample, reference;
  std::vector<double> phases_degrees;  ///< of both; empty: spread evenly over 360
  std::optional<std::string> dark;     ///< subtracted from all of them
};

/// Absorbers whose amounts are fitted to μa of all wavelengths.
struct Spectra {
  /// Of forward/lateral/chromophores.h, or columns of `file`.
  std::vector<std::string> absorbers;
  /// CSV with a column wavelength_nm and one by absorber: absorption of one unit [1/mm]. Empty:
  /// tables of forward/lateral/chromophores.h.
  std::string file;
};

struct Description {
  std::filesystem::path folder;
  double pixel_mm = 0.0;
  std::optional<double> smoothing_mm;           ///< absent: usual_smoothing_mm
  std::string channel;                          ///< "R", "G" or "B" of colour pictures; else empty
  std::optional<std::array<int, 4>> crop_px;    ///< x, y, width, height of what is read
  std::optional<std::array<int, 4>> region_px;  ///< within the crop: summed up by itself
  std::optional<double> largest_code;           ///< codes from here on are saturated
  std::optional<double> codes_per_reflectance;  ///< absolute scale, without a phantom
  Medium medium;
  std::optional<Reference> reference;
  std::optional<Errors> errors;
  std::optional<Spectra> spectra;
  std::optional<ProjectorPlace> projector;  ///< stated: height and tilt are measured and corrected
  std::vector<Pictures> measurements;
};

/// Throws InputError naming file, field and fix.
Description read_description(const std::filesystem::path& folder_or_file);

}  // namespace kappamu::pipeline::sfdi
