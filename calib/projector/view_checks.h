// What is wrong with a set of board photographs, told by view. The edges at which each check speaks
// are measured in docs/limits.md.
#pragma once

#include <string>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/projector/projector.h"

namespace kappamu::calib {

/// Sentences about boards that are too nearly parallel (focal length known to 2 to 5 %), that leave
/// a side of the picture unseen, that are blurred, or whose corners were left out as outliers.
/// Throws InputError where the focal length is known to worse than 5 %.
std::vector<std::string> check_camera_views(const std::vector<BoardView>& views,
                                            const CameraCalibration& camera);

/// Sentences about projected boards that are turned against the others.
std::vector<std::string> check_planes(const std::vector<PlaneView>& planes);

/// A sentence if the planes stand at another distance from the camera than the sample: the size of
/// the printed squares sets the projector's place, the size of the block the sample's, and nothing
/// else compares the two.
std::vector<std::string> check_scale(const std::vector<Rigid>& station_from_plane,
                                     const Rigid& camera_from_sample, double square_mm);

/// Largest angle [degrees] between the normals of any two boards.
double largest_tilt_degrees(const std::vector<Rigid>& camera_from_board);

}  // namespace kappamu::calib
