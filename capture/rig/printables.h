// What a planned capture needs on paper: the board to print, and a sketch of where things stand.
#pragma once

#include <string>

#include "capture/session/session.h"

namespace kappamu::capture {

/// A PDF of one page with the chessboard at its true size (one square of white around it, a line
/// that states the size to check with a ruler). The page is A4 or A3 where the board fits it,
/// upright or across, else as large as the board. Throws InputError for boards that are no
/// chessboards.
std::string board_pdf(const Board& board);

/// An SVG seen from above: projector, block with lit and seen face, the camera's stations, and the
/// sample's axes. The projector shines along z; its picture's x is the sample's x.
std::string rig_sketch(const Sample& sample, Setup setup);

}  // namespace kappamu::capture
