// sfdi.json: what the pictures of a spatial frequency domain measurement show (docs/sfdi.md has the
// fields). Any lab writes it by hand beside its pictures, or lets a script.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/names.h"

namespace kappamu::pipeline::sfdi {

inline constexpr const char* file_name = "sfdi.json";

/// Standard deviation of the Gaussian that averages what is demodulated pixel by pixel. Light mixes
/// over a transport mean free path, 0.5 to 2 mm: detail below is noise and texture of the surface.
inline constexpr double usual_smoothing_mm = 0.5;

/// Known coefficients at one wavelength, of a reference phantom or of a layer.
struct PhantomRow {
  double wavelength_nm = 0.0;
  double absorption_per_mm = 0.0;          ///< μa
  double reduced_scattering_per_mm = 0.0;  ///< σs'
  /// Standard deviations of both over both; absent: exactly known.
  std::optional<std::array<double, 2>> relative_deviation;
};

/// A layer of known coefficients.
struct Layer {
  std::vector<PhantomRow> coefficients;  ///< by wavelength, linear in between
  std::optional<double> thickness_mm;    ///< of a cover
};

struct Medium {
  double refractive_index = 1.4;
  std::optional<double> refractive_index_deviation;  ///< standard; absent: exactly known
  double anisotropy = 0.9;                           ///< g
  std::optional<double> anisotropy_deviation;        ///< standard; absent: exactly known
  std::optional<double>
      thickness_mm;  ///< of a slab, or of the layer over `base`; absent: half-space
  std::optional<double> slide_index;  ///< of glass on both sides of a slab; absent: none
  std::optional<Layer> cover;         ///< known layer over what is measured
  std::optional<Layer> base;          ///< known half-space under it
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

/// What pictures hold.
enum class Content {
  light,        ///< a camera's codes under a sinusoid or even light
  demodulated,  ///< the amplitude at each pixel; under even light the mean
  ratio         ///< that of the sample over that of the phantom
};
inline constexpr Names<Content, 3> content_names{
    {{"light", Content::light}, {"demodulated", Content::demodulated}, {"ratio", Content::ratio}}};

/// Which side of a slab is seen.
enum class Side {
  near,  ///< the lit one: reflectance
  far    ///< the other one: transmittance
};
inline constexpr Names<Side, 2> side_names{{{"near", Side::near}, {"far", Side::far}}};

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
  std::optional<int> repeats;          ///< so many pictures in a row are one, averaged; absent: 1
  Content content = Content::light;
  Side side = Side::near;
};

/// Pictures of many wavelengths, frequencies and phases whose names follow a rule. In a name,
/// {wavelength}, {frequency} and {phase} stand for numbers in the order of the lists, from
/// first_number; {wavelength_nm}, {per_mm} and {phase_degrees} for the values. {phase:2} has at
/// least two digits. A name without {phase} stands for all phases: a folder of frames or a stack.
struct Series {
  std::string sample, reference, dark;  ///< names; the last two may be empty
  std::vector<double> wavelengths_nm, per_mm, phases_degrees;
  std::optional<int> first_number;          ///< absent: 0
  std::optional<double> direction_degrees;  ///< of all sinusoids
  std::optional<int> repeats;
  Content content = Content::light;
  Side side = Side::near;
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
  std::optional<double> largest_code;  ///< codes from here on are saturated; none: as pictures show
  std::optional<double> codes_per_reflectance;  ///< absolute scale, without a phantom
  Medium medium;
  std::optional<Reference> reference;
  std::optional<Errors> errors;
  std::optional<Spectra> spectra;
  std::optional<ProjectorPlace> projector;  ///< stated: height and tilt are measured and corrected
  std::optional<Series> series;
  std::vector<Pictures> measurements;  ///< by name, and those of the series; names of one picture
};

/// Folders of frames and stacks are looked up. Throws InputError naming file, field and fix.
Description read_description(const std::filesystem::path& folder_or_file);

}  // namespace kappamu::pipeline::sfdi
