// A run folder made up without any solver: shapes, files and magnitudes of a real one, contents
// from formulas. For tests of what only reads runs.
#pragma once

#include <filesystem>

namespace kappamu {

struct MadeUpRun {
  int nx = 40, ny = 32, nz = 12;
  int fit_patterns = 6;
  int validate_patterns = 2;
  double model_error = 0.002;  ///< relative error of the "re-rendered" values
  double camera_rms_px = 0.12;
  bool converged = true;
  bool with_session = true;  ///< calibration, HDR and session beside fit and measurements
};

/// Writes folder/run and, with a session, folder/session; returns folder/run.
std::filesystem::path make_run(const std::filesystem::path& folder, const MadeUpRun& options);

}  // namespace kappamu
