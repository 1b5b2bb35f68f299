// The files that a fit reads and writes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/surface_measurements.h"
#include "pipeline/records/fit_options.h"

namespace kappamu::pipeline {

/// Of a fit's folder: kappa_<c>.npy and mu_<c>.npy of volumes that have not seen the
/// validation patterns of the input (inverse/validation/validated_fit.h).
inline constexpr const char* validated_folder = "validated";

/// The measurements folder that `input` means: one with measurements.json, or a run folder that has
/// measurements/. Throws InputError when there is none.
std::filesystem::path find_measurements(const std::filesystem::path& input);

/// The folder of validation measurements that a fit of `input` uses: the option's, or
/// measurements_validate beside them; none where there is neither.
std::optional<std::filesystem::path> find_validation(const std::filesystem::path& input,
                                                     const FitStageOptions& options);

/// Throws InputError unless both describe the same sample, so that one volume answers for both;
/// `folder` is that of `validation`.
void require_same_sample(const SurfaceMeasurements& fitted, const SurfaceMeasurements& validation,
                         const std::filesystem::path& folder);

/// The folders that run_fit_stage() (stages/fit_stage.h) reads.
std::vector<std::filesystem::path> fit_inputs(const std::filesystem::path& input,
                                              const FitStageOptions& options);

/// Names of what run_fit_stage() may write in a folder and of what lies there under such a name.
std::vector<std::string> fit_outputs(const std::filesystem::path& folder);

struct FitInput {
  SurfaceMeasurements measurements;
  std::optional<SurfaceMeasurements> validation;  ///< measurements of their own that validate
};

/// Reads `input` (see find_measurements) and its validation measurements, where there are any.
/// Throws InputError, also where these are not of the same sample.
FitInput read_fit_input(const std::filesystem::path& input, const FitStageOptions& options);

/// Their numbers among those measured, in the order of `names`; none named: all. Throws InputError.
std::vector<int> channels_of(const SurfaceMeasurements& measurements,
                             const std::vector<std::string>& names);

}  // namespace kappamu::pipeline
