// Frames of a stack moved onto one another.
#pragma once

#include <array>

#include "capture/radiance/hdr.h"
#include "capture/response/exposed_frame.h"

namespace kappamu::capture {

/// The frame as if its picture had not been shifted by `shift_px` (x, y): bilinear between its
/// pixels, beyond its edge the nearest one. A pixel that draws on a value of `saturated_from` or
/// more takes the largest it draws on. Noise between pixels is averaged: the variance of single
/// pixels is at most what the noise model says, that of means over areas the same.
void move_back(const std::array<double, 2>& shift_px, int saturated_from, ExposedFrame& frame);
void move_back(const std::array<double, 2>& shift_px, float saturated_from,
               ExposedFloatFrame& frame);

/// Flags pixels as missing that a frame shifted by `shift_px` did not see.
void flag_unseen(const std::array<double, 2>& shift_px, HdrImage& image);

}  // namespace kappamu::capture
