// Measurements to volumes: what `kappamu fit` and the fit stage of `kappamu run` share.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.h"
#include "inverse/fit/fit.h"
#include "inverse/validation/validation_patterns.h"
#include "pipeline/records/fit_options.h"
#include "pipeline/records/fit_record.h"

namespace kappamu::pipeline {

struct FitSummary {
  std::vector<std::string> channels;
  std::vector<inverse::FitReport> reports;  ///< one per channel
  std::vector<inverse::ValidationScore>
      validation;  ///< one per channel; empty where none is kept out
  /// One per channel, or empty where none was asked for.
  std::vector<std::optional<inverse::UncertaintyReport>> uncertainty;
  std::vector<std::vector<std::string>> notes;  ///< one list per channel (inverse/fit/notes.h)
  std::string device;
  std::filesystem::path volume;
  double seconds = 0.0;
  double memory_needed = 0.0;  ///< at the peak, as predicted before the fit [bytes] (fit_memory.h)
  FitRecord record;            ///< status and verdict of all channels together
};

/// Fits every channel of `input` (see find_measurements) and writes into `output`: kappa_<c>.npy,
/// mu_<c>.npy, sensitivity_<c>.npy [z][y][x], those of write_uncertainty(), prediction.npy and,
/// with validation measurements, prediction_validate.npy [C][M][v][u], volume.vdb, and fit.json
/// last (docs/formats.md). While it works, checkpoint_<c>.bin and checkpoint_all_<c>.bin, and
/// beside each the one before, hold what it needs to go on where it was killed; they are removed at
/// the end. Throws InputError.
FitSummary run_fit_stage(const std::filesystem::path& input, const std::filesystem::path& output,
                         const FitStageOptions& options, Progress& progress);

}  // namespace kappamu::pipeline
