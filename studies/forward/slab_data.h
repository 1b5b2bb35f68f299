// Measured slabs: total reflectance and transmittance of real samples with the coefficients that
// inverse adding-doubling found for them. Reads S. Prahl's .rxt files (github.com/scottprahl/iad,
// tests/rxt) and the table peer_iad.csv that his program made of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kappamu::studies {

/// One integrating sphere; lengths [mm], reflectances dimensionless.
struct Sphere {
  double diameter = 0.0, sample_port = 0.0, third_port = 0.0, detector_port = 0.0;
  double wall_reflectance = 0.0;

  /// Light on the detector per light thrown diffusely into the sphere, the sample reflecting
  /// `sample` and what closes the third port `third`; black detector, a baffle before the sample.
  double gain(double sample, double third) const;
  /// What one bounce off the wall leaves of light from the sample, which the baffle keeps from the
  /// detector.
  double first_bounce(double third) const;

 private:
  double share(double port) const { return port * port / (4.0 * diameter * diameter); }
};

struct MeasuredSlab {
  std::string file, row;
  double n_sample = 1.0, n_slide = 1.0;
  double thickness = 0.0;              ///< [mm]
  int spheres = 0;                     ///< at a time; 0: values are corrected for them already
  double standard = 1.0;               ///< reflectance of the calibration standard
  double transmission_standard = 1.0;  ///< of what closes the transmission sphere's third port
  Sphere reflection, transmission;
  double reflectance = 0.0, transmittance = 0.0;  ///< as measured, M_R and M_T
  double sigma_a = 0.0, sigma_s_prime = 0.0;      ///< by inverse adding-doubling [1/mm]
  double anisotropy = 0.0;

  double mean_free_paths() const { return thickness * (sigma_a + sigma_s_prime); }
  double albedo() const { return sigma_s_prime / (sigma_a + sigma_s_prime); }
};

/// All rows of `folder` whose inversion converged, in order of peer_iad.csv. Throws InputError
/// naming file and line of what cannot be read.
std::vector<MeasuredSlab> read_measured_slabs(const std::filesystem::path& folder);

}  // namespace kappamu::studies
