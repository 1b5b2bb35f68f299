// Measurements to volumes: what `kappamu fit` and the fit stage of `kappamu run` share.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.h"
#include "inverse/fit.h"

namespace kappamu::app {

struct FitStageOptions {
  inverse::FitOptions fit;
  std::vector<std::string> channels;  ///< names of those to fit; empty = all
  /// Measurements under held-out light; found beside the input when not given.
  std::optional<std::filesystem::path> validate;
  bool restart = false;  ///< ignore checkpoints
};

struct FitSummary {
  std::vector<std::string> channels;
  std::vector<inverse::FitReport> reports;  ///< one per channel
  /// Σ(L'−L)²/ΣL² of prediction against measurement over what the held-out masks allow, and the
  /// part of it that the measurements' own variance explains; by channel.
  std::vector<double> holdout_error;
  std::vector<double> holdout_noise;
  std::string device;
  std::filesystem::path volume;
  double seconds = 0.0;

  bool converged() const;  ///< every channel
};

/// The measurements folder that `input` means: one with measurements.json, or a run folder that has
/// measurements/. Throws InputError when there is none.
std::filesystem::path find_measurements(const std::filesystem::path& input);

/// Fits every channel of `input` (see find_measurements) and writes into `output`: kappa_<c>.npy,
/// mu_<c>.npy, sensitivity_<c>.npy [z][y][x], prediction.npy and, with held-out patterns,
/// prediction_validate.npy [C][M][v][u], volume.vdb, and fit.json last (docs/formats.md). While it
/// works, checkpoint_<c>.bin hold what it needs to go on where it was killed; they are removed at
/// the end. Throws InputError.
FitSummary run_fit_stage(const std::filesystem::path& input, const std::filesystem::path& output,
                         const FitStageOptions& options, Progress& progress);

}  // namespace kappamu::app
