// What the projector shows while a plan is shot, by the names that Shot::show has.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "capture/rig/shoot.h"

namespace kappamu::capture {

inline constexpr const char* board_picture = "calibration/projected_board.png";
std::string level_picture(int value);
std::string gray_picture(std::size_t number);
std::string phase_picture(std::size_t set, std::size_t step);
std::string pattern_picture(const PlannedPattern& pattern);
/// `stem` and two digits.
std::string numbered(const std::string& stem, std::size_t number);

/// Whether planes are shown the projected board.
bool chessboards(PlaneLight light);

/// Throws InputError where the plan contradicts itself or the projector.
void check_plan(const CapturePlan& plan, const Projector& projector);

/// Of a checked plan.
std::map<std::string, Image<std::uint8_t>> shown_pictures(const CapturePlan& plan,
                                                          const Projector& projector);

}  // namespace kappamu::capture
