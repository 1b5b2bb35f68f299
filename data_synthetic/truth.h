// The ground truth of a simulated capture, kept apart from its session: only the simulator writes
// it and only `kappamu score` reads it. Layout of the folder:
//   truth.json               this structure
//   kappa_R.npy, mu_R.npy …  [z][y][x] on the transport grid
//   holdout_irradiance.npy   [n²][v][u] on the fitted grid's lit face: patches the session never
//   shows holdout_exitance.npy     [C][n²][v][u] noise-free, mean over the fitted grid's seen-face
//   voxels radiance/<pattern>.exr   R, G, B: noise-free picture of the pattern in full scales per
//   second
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calib/lens/lens.h"
#include "capture/session/session.h"
#include "core/rigid.h"
#include "data_synthetic/rig/rig.h"

namespace kappamu::synthetic {

struct Truth {
  std::string sample;
  std::uint64_t seed = 0;
  std::vector<std::string> channels{"R", "G", "B"};
  GridShape grid;               ///< what the session asks to fit
  GridShape transport_grid;     ///< where light was computed: finer, over the same block
  std::string transport_model;  ///< the physics, in a few words
  std::string transport_backend;
  double eta = 1.3;
  capture::Setup setup = capture::Setup::back_lit;
  Face lit_face = Face::z_minus;
  Face seen_face = Face::z_plus;
  Sides sides = Sides::open;
  int holdout = 0;  ///< n of the n × n held-out patches; 0: none were made

  calib::Lens camera_lens;
  ProjectorModel projector;
  Rigid world_from_sample;
  std::map<std::string, Rigid> world_from_camera;  ///< by station
  std::string calibration_station;
  std::string pattern_station;
  SensorModel sensor;
  std::array<double, 3> responsivity{};  ///< full scales per second for unit radiance

  Rigid camera_from_sample(const std::string& station) const {
    return world_from_camera.at(station).inverse() * world_from_sample;
  }
  Rigid projector_from_sample() const { return projector.projector_from_world * world_from_sample; }
};

void write_truth(const std::filesystem::path& folder, const Truth& truth);
/// Throws InputError naming file and field.
Truth read_truth(const std::filesystem::path& folder);

}  // namespace kappamu::synthetic
