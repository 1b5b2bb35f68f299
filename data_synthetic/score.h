// A finished run held against the truth of its simulated capture.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "core/progress.h"
#include "data_synthetic/truth.h"

namespace kappamu::synthetic {

/// How far a run's calibration is from the true rig.
struct CalibrationErrors {
  double camera_focal_relative = 0.0;     ///< fx, |found/true − 1|
  double projector_focal_relative = 0.0;  ///< the same of the projector
  /// Largest distance between where found and true camera (lens and pose at the pattern station)
  /// see the same points of the seen face, in camera pixels.
  double camera_face_px = 0.0;
  /// The same of the projector on the lit face, in projector pixels.
  double projector_face_px = 0.0;
  double camera_angle_degrees = 0.0;     ///< of camera_from_sample at the pattern station
  double camera_position_mm = 0.0;       ///< camera centre in the sample frame
  double projector_angle_degrees = 0.0;  ///< of projector_from_sample
  double projector_position_mm = 0.0;    ///< projector centre in the sample frame
  double scale_relative = 0.0;  ///< full scales per second for unit radiance, worst channel
  double projector_black_relative = 0.0;  ///< the projector's black level, |found/true − 1|
};

/// Whether stated standard deviations hold: z = (log found − log truth)/deviation of the logarithm,
/// the truth as resolved() by the fit.
struct Coverage {
  double within_two = 0.0;  ///< share of voxels with |z| ≤ 2; 0.954 if errors are as stated
  double median = 0.0;      ///< of |z|; 0.674 if they are
  std::vector<double> within_two_by_depth;  ///< the share in each layer below the lit face
};

/// Parts the run does not have are absent.
struct Score {
  std::vector<std::string> channels;  ///< names, in the truth's order
  /// E = Σ(L' − L)²/ΣL² over all channels, held-out patches and voxels of the seen face (where one
  /// face is lit and seen: its unlit voxels), the run's volumes solved on a grid refined twice.
  std::optional<double> truth_E;
  std::map<std::string, double> truth_E_by_channel;
  /// |found/true − 1| of HDR radiance: median over all pixels on the sample without a flag.
  std::optional<double> hdr_relative_error_median;
  std::map<std::string, double> hdr_relative_error_by_pattern;
  double hdr_valid_fraction = 0.0;  ///< of the pixel values on the sample
  /// Median of |found/true − 1| by channel and layer below the lit face; the truth averaged over
  /// the fitted voxel.
  std::map<std::string, std::vector<double>> kappa_relative_error_by_depth;
  std::map<std::string, std::vector<double>> mu_relative_error_by_depth;
  std::optional<double> kappa_relative_error;  ///< the same over all voxels and channels
  std::optional<double> mu_relative_error;
  std::map<std::string, Coverage> kappa_coverage;  ///< by channel
  std::map<std::string, Coverage> mu_coverage;
  std::optional<CalibrationErrors> calibration;
  double seconds = 0.0;
};

/// Reads run/hdr, run/fit, run/calibration and the truth folder. Throws InputError naming what does
/// not fit together, or when the run has none of the three.
Score score_run(const std::filesystem::path& run, const std::filesystem::path& truth_folder,
                const std::string& device, Progress& progress);

/// What a fit can find of a `truth`: exp of the means of its logarithm over `fwhm_mm`, stated by
/// layer from the face that the camera sees on; empty: the truth itself.
Volume<double> resolved(Volume<double> truth, Face seen, const std::vector<double>& fwhm_mm);

/// `log_deviation`: stated for the logarithm of `found`; `truth` as resolved.
Coverage coverage(const Volume<double>& found, const Volume<double>& truth,
                  const Volume<double>& log_deviation, Face lit_face);

/// Mean over the cells of each coarser voxel.
Volume<double> average_volume(const Volume<double>& fine, const GridShape& coarse);

/// Of one channel, averaged over each fitted voxel.
Medium true_medium(const Truth& truth, const std::filesystem::path& truth_folder,
                   const std::string& channel);

CalibrationErrors calibration_errors(const calib::CalibrationResult& found, const Truth& truth);

/// E of media on the fitted grid under the held-out patches of `truth`, all channels pooled;
/// each channel's own goes to `by_channel`.
double truth_error(const std::vector<Medium>& media, const Truth& truth,
                   const std::filesystem::path& truth_folder, const std::string& device,
                   Progress& progress, std::map<std::string, double>* by_channel = nullptr);

}  // namespace kappamu::synthetic
