// What the rig holds before its camera to be calibrated: printed chessboard, blank plane, white
// target, colour chart.
#pragma once

#include <array>

#include "capture/session/session.h"
#include "data_synthetic/rig/render.h"

namespace kappamu::synthetic {

inline constexpr double paper_reflectance = 0.85;
inline constexpr double ink_reflectance = 0.04;
inline constexpr double white_target_reflectance = 0.99;
/// White paper around the board's outer squares, in squares.
inline constexpr double board_margin_squares = 0.6;

/// Radius of a circle grid's dots over the distance of neighbours.
inline constexpr double dot_radius = 0.25;

/// Printed board of any kind with a white margin: chessboards of (columns + 1) × (rows + 1)
/// squares, the first one black. The quad's origin is inner corner or dot (0, 0), x along a row.
Quad board_quad(const capture::Board& board, const Rigid& world_from_board);

/// Evenly reflecting rectangle centred on the origin of its frame.
Quad plain_quad(const Eigen::Vector2d& size_mm, double reflectance, const Rigid& world_from_quad);

/// ColorChecker Classic, centred on its frame's origin, `width_mm` wide: 6 × 4 patches with gaps on
/// a dark frame.
Quad chart_quad(double width_mm, const Rigid& world_from_chart);
double chart_height_mm(double width_mm);

/// Linear reflectances R, G, B of the 24 patches, row by row from dark skin to black: X-Rite's
/// L*a*b* (D50) of charts made after November 2014. Neutral patches have Y/100 in every channel;
/// the others go through linear sRGB (Bradford-adapted to D50), clipped to [0.005, 1].
const std::array<std::array<double, 3>, 24>& chart_reflectances();

}  // namespace kappamu::synthetic
