// A fit by itself, from folder to folder: what `kappamu fit` and the Python package share.
#pragma once

#include <filesystem>
#include <optional>

#include "pipeline/stages/fit_stage.h"

namespace kappamu::pipeline {

struct FitFolders {
  std::filesystem::path input;  ///< as find_measurements() takes it; empty: that of `continued`
  std::filesystem::path out;    ///< made if missing; empty: <fit>_continued beside `continued`
  std::optional<std::filesystem::path> continued;  ///< a finished fit or run to go on from
};

/// Fits and leaves in `out` what run_fit_stage() writes, whole or not at all; an interrupted fit of
/// the same input and options goes on where it was. `options` are resolved. Throws InputError.
FitSummary fit_folder(FitFolders folders, FitStageOptions options, Progress& progress);

}  // namespace kappamu::pipeline
