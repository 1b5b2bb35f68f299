// The simulated rig: everything true about projector, camera, their places, and the sample's mount.
// The pipeline sees none of it.
//
// World frame: origin where the middle of the sample's lit face is meant to be, z away from the
// projector, x to its right, y down. All sizes follow from S, the sample's width in a 4:3 picture:
//   projector        7 S before the lit face, its picture 2 S wide
//   station "front"  17° to the projector's side, its picture about 2.9 S wide
//   station "back"   behind the sample, 2° off the normal, its picture about 1.4 S wide
//   station "side"   on the projector's other side, 22° off the normal, its picture about 1.6 S
//   wide
// Seen from "front", the projected chessboard (1.15 S wide) covers the place of the sample and the
// printed board lies to its left, outside the projector's picture.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "capture/session/session.h"
#include "data_synthetic/rig/projector_light.h"
#include "data_synthetic/rig/sensor.h"
#include "data_synthetic/scene/materials.h"
#include "data_synthetic/simulation_options.h"

namespace kappamu::synthetic {

inline constexpr const char* front_station = "front";
inline constexpr const char* back_station = "back";
inline constexpr const char* side_station = "side";

struct Rig {
  SampleModel sample;
  double size_mm = 0.0;  ///< S
  capture::Projector projector_size;
  ProjectorModel projector;
  calib::Lens camera_lens;
  SensorModel sensor;
  /// Full scales per second for unit radiance, per channel R, G, B; set once the patterns' radiance
  /// is known (choose_gain).
  std::array<double, 3> responsivity{0.75, 1.0, 0.65};
  Rigid world_from_sample;  ///< with the mount's error
  std::map<std::string, Rigid> world_from_camera;
  capture::Board board;
  capture::ProjectedBoard projected_board;
  std::vector<Rigid> camera_from_board;  ///< poses of the printed board, quad frame of board_quad()
  std::vector<Rigid> world_from_plane;   ///< poses of the projector planes
  Rigid plane_from_board;                ///< the printed board on each plane

  bool two_stations = false;  ///< patterns are seen from "front" too
  std::string pattern_station() const {
    if (sample.setup == capture::Setup::back_lit) return back_station;
    return two_stations ? side_station : front_station;
  }
  /// World frame of a target lying in the plane of the lit face, centred on it.
  Rigid world_from_target() const;
};

Rig make_rig(const SimulationOptions& options);

/// Scales the rig's responsivity so that `brightest` radiance, in the most sensitive channel, fills
/// full scale in `exposure_s`.
void choose_gain(Rig& rig, double brightest, double exposure_s);

}  // namespace kappamu::synthetic
