// Sessions made of photographs alone, for those who want one stage of the work: a bracket to merge,
// boards and Gray codes to calibrate from. They live in memory and are valid for that stage only.
#pragma once

#include <filesystem>
#include <optional>

#include "capture/import/import_photographs.h"
#include "capture/session/session.h"
#include "core/progress.h"

namespace kappamu::capture {

/// All photographs of the source as one stack, the pattern "bracket"; those of shot "dark" are the
/// dark frames. Files of 8 bits are taken as encoded by an unknown response unless `encoding` says
/// linear; RAW and EXR are linear, deeper PNG and TIFF as `encoding` says, of the fewest bits that
/// hold their largest code. Throws InputError as import_session() does.
Session bracket_session(const PhotographSource& source, Encoding encoding, Progress& progress);

/// One photograph, the pattern "photograph"; its camera as in bracket_session().
Session photograph_session(const std::filesystem::path& photograph, Encoding encoding);

/// Photographs of a printed board and, with `projector`, of its Gray codes: shots
/// plane_<n>_gray_<k> and plane_<n>_board are projector planes (session.h), all others boards. A
/// file plane_<n>_correspondences.npy or .csv (calib/projector/correspondences.h) takes the place
/// of a plane's Gray code.
/// Exposure times are not needed. Throws InputError as import_session() does.
Session board_session(const PhotographSource& source, const Board& board,
                      const std::optional<Projector>& projector, Progress& progress);

}  // namespace kappamu::capture
