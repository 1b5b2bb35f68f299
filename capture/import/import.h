// A folder of photographs becomes a capture session.
#pragma once

#include <filesystem>
#include <optional>

#include "capture/import/import_photographs.h"
#include "capture/session/session.h"
#include "capture/session/session_files.h"
#include "core/progress.h"

namespace kappamu::capture {

struct ImportOptions {
  std::filesystem::path photographs;  ///< folder, searched with its subfolders
  /// Folder with a session.json that tells what photographs cannot: sample, projector, boards,
  /// stations, patterns. Its frames and the camera's size are replaced. `kappamu plan` writes one.
  std::filesystem::path plan;
  /// The session's folder. The photographs are copied into it unless they lie in it already.
  std::filesystem::path out;
  /// CSV with the columns file, shot and, optionally, exposure_s; without it file names tell the
  /// shot (docs/formats.md).
  std::optional<std::filesystem::path> table;
  Links links = Links::within;  ///< anywhere: also photographs behind links out of their folder
  std::optional<Orientation> orientation{};  ///< none: ignore, with a warning where it matters
};

/// Exposure times come from EXIF or the table; the camera's size, depth and encoding from the
/// files. Throws InputError, one sentence naming the photograph, for one that belongs to no shot,
/// has no exposure time, another aperture, sensitivity, focal length or camera than the rest, or is
/// brighter or darker than its exposure time allows; for shots without photographs; and where it
/// would replace a file that is another. Optional
/// shots that are missing are left out with a warning.
Session import_session(const ImportOptions& options, Progress& progress);

}  // namespace kappamu::capture
