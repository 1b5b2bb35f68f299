// What a calibration's detectors would find in pictures of the simulated rig: corners by geometry,
// with noise of any size. A rendered corner is found within 0.002 px, a real one within 0.03 to
// 0.1 px (docs/calibration.md).
#pragma once

#include <random>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/projector/projector.h"
#include "data_synthetic/rig/rig.h"

namespace kappamu::studies {

struct RigCorners {
  /// Printed boards; the last are those of the planes, in their order
  /// (calib/projector/bundle_adjustment.h).
  std::vector<calib::BoardView> views;
  std::vector<calib::PlaneView> planes;
};

/// A chessboard of `camera_from_board`, whose corners scatter by `noise_px` per coordinate.
calib::BoardView seen_board(const calib::Lens& camera, const capture::Board& board,
                            const Rigid& camera_from_board, double noise_px,
                            std::mt19937_64& random);

/// Every printed board and every plane of the rig, chessboards.
RigCorners seen_corners(const synthetic::Rig& rig, double noise_px, std::mt19937_64& random);

}  // namespace kappamu::studies
