// Everything the report says, read from a run folder. Parts a run does not have are empty: a fit of
// someone's measurements has no calibration and no HDR images.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "capture/session/session.h"
#include "core/appearance_error.h"
#include "core/grid.h"
#include "core/image.h"
#include "core/surface_measurements.h"
#include "pipeline/records/run_record.h"
#include "pipeline/records/verdict.h"

namespace kappamu::report {

/// The sample as a station photographed it, with the voxels' edges drawn where calibration puts
/// them.
struct SamplePicture {
  std::string station;
  std::string face;
  Image<std::uint8_t> image;
};

/// What one pattern's HDR image is worth.
struct HdrSummary {
  std::string pattern;
  Image<float> thumbnail;  ///< radiance [full scales/s], reduced
  double bright = 0.0;     ///< 99.9 % quantile of valid radiance [full scales/s]
  double noise = 0.0;      ///< smallest 1 % quantile of the standard deviation [full scales/s]
  double saturated = 0.0;  ///< fraction of pixel values saturated in every frame
  double dark = 0.0;       ///< fraction below the noise in every frame
  double missing = 0.0;    ///< fraction without a frame
  /// log10 of the largest channel's standard deviation over value; not a number where some pixel is
  /// dark, saturated or missing. Reduced like the thumbnail.
  Image<float> relative_noise;
  Image<float> saturation;  ///< share of values saturated in every frame, reduced
};

/// How the optimiser got there, one colour channel.
struct Convergence {
  std::string channel;
  std::string status;                  ///< converged, above_noise or ran_out
  std::string reason;                  ///< why it stopped
  std::string model;                   ///< homogeneous, layered or volume; empty if not stated
  std::string model_reason;            ///< why that one
  std::vector<std::string> notes;      ///< what the reader should know though nothing is wrong
  std::vector<double> adjoint_solves;  ///< so far
  std::vector<double> objective;       ///< dimensionless
  std::vector<double> chi2;            ///< χ² per value after the same solves
  double chi2_per_value = 0.0;         ///< Σ (residual²/variance) / values used
  std::optional<double> seconds;
};

/// How far one channel's volumes can be trusted (inverse/uncertainty/uncertainty.h).
struct FitUncertainty {
  std::string sentence;
  Medium deviation;   ///< of log κ and log μ [dimensionless]
  Medium resolution;  ///< share of the variance that the data removed, of κ and of μ
};

struct FitData {
  pipeline::Verdict verdict;
  std::vector<Medium> media;  ///< per channel, in the order of `channels`
  int means_of = 1;           ///< voxels of the fit along each edge of a voxel of `media`
  /// Where those are means, the middle layer of κ and μ as fitted, [y][x], and its place [mm].
  std::vector<std::array<Image<float>, 2>> middle_layers;
  double middle_mm = 0.0;
  std::vector<std::optional<FitUncertainty>> uncertainty;  ///< the same; where the fit tells one
  std::vector<std::string> channels;
  std::vector<Convergence> convergence;
  std::vector<std::string> warnings;
  bool lit_pixels = false;      ///< they are used (pipeline/lit_pixels.h)
  std::vector<int> validation;  ///< patterns of the measurements that the fit did not see
};

/// Measured surfaces and what the fitted volume predicts for them.
struct Comparison {
  SurfaceMeasurements measured;
  std::vector<float> predicted;       ///< [C][M][v][u] like measured.value; empty without a fit
  std::vector<std::string> patterns;  ///< M names
};

struct RunData {
  std::filesystem::path folder;
  std::optional<pipeline::RunRecord> record;
  std::optional<capture::Session> session;  ///< absent when the session folder is gone
  std::optional<calib::CalibrationResult> calibration;
  std::vector<SamplePicture> sample_pictures;
  std::vector<HdrSummary> hdr;
  std::optional<Comparison> fit_patterns;
  std::optional<Comparison> validate_patterns;  ///< those kept out of the fit
  std::optional<FitData> fit;
};

/// Reads what there is. Throws InputError when `run` holds neither measurements nor a fit, or when
/// a file that is there is damaged.
RunData read_run(const std::filesystem::path& run);

/// The session's sample views that still have their photograph.
std::vector<SamplePicture> sample_pictures(const capture::Session& session,
                                           const calib::CalibrationResult& calibration);
/// Sets `data`'s patterns, of the fit and kept out of it, from its folder, record, session and fit.
void read_comparisons(RunData& data);
std::vector<HdrSummary> summarise_hdr(const std::filesystem::path& run);
std::optional<FitData> read_fit(const std::filesystem::path& run);

/// Over all channels and the values that the mask allows, of one pattern or of all.
AppearanceError appearance_error(const Comparison& comparison,
                                 std::optional<std::size_t> pattern = std::nullopt);

/// One pattern of `values` [C][M][v][u] as an image, channels last; three channels at most.
Image<float> pattern_image(const SurfaceMeasurements& measured, const std::vector<float>& values,
                           std::size_t pattern);

}  // namespace kappamu::report
