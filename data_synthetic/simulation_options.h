// What a user may choose about a simulated capture.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/rig/shoot.h"
#include "data_synthetic/transport.h"

namespace kappamu::synthetic {

struct SimulationOptions {
  std::string sample = "demo";  ///< see sample_names()
  /// Voxels along x, y, z instead of the sample's own, for quick variants.
  std::optional<std::array<int, 3>> grid;
  capture::FitLight light;   ///< patterns to fit, bars 1 to 64, patches 1 to 16, sinusoids
  bool validation = true;    ///< add validation patterns: 4 of 8 × 8 patches, a cross, a checker
  double noise_scale = 1.0;  ///< factor on shot and read noise, 0 (none) to 10
  /// The patterns are photographed from the calibration station too: on the lit face, which of
  /// front-lit samples is seen twice.
  bool both_faces = false;
  /// Mean diffuse reflectance of the lit face's surface, over its scattering; 0 (none) to 0.5. Lit
  /// pixels are then exposed for.
  double surface_reflectance = 0.0;
  std::uint64_t seed = 1;  ///< of the sample's structure, the rig's imperfections and the noise
  int bit_depth = 12;      ///< 8 to 16
  capture::Encoding encoding = capture::Encoding::response;
  /// Exposure times of each pattern [s], rising; six in geometric steps as in the paper: 1/30
  /// ... 8.
  std::vector<double> exposures_s = geometric_exposures(1.0 / 30.0, 8.0, 6);
  /// Camera picture [px]; the sample's default where absent: 640 × 480 for demo, 400 × 300 for
  /// tiny, 1280 × 960 for the paper's samples.
  std::optional<std::array<int, 2>> camera_size;
  std::array<int, 2> projector_size{1024, 768};  ///< [px]
  /// Further pattern pictures (PNG or TIFF of the projector's size), with the role "validate".
  std::vector<std::filesystem::path> pattern_files;
  int board_views = 15;                                       ///< printed-board pictures, 3 to 60
  int projector_planes = 10;                                  ///< planes, 3 to 40
  capture::BoardKind board = capture::BoardKind::chessboard;  ///< the printed one
  double projector_gamma = 1.0;  ///< its light goes as value^gamma; 0.2 to 5
  int projector_levels = 0;      ///< values between black and white shot on the white target
  /// Room light during the shots in the dark, as irradiance over that of the projector's white; the
  /// session then has photographs with the projector off.
  double room_light = 0.0;
  double room_change = 0.0;  ///< its relative change from the first pattern to the last
  capture::PlaneLight plane_light = capture::PlaneLight::chessboard;  ///< thrown on the planes
  int rays_per_side = 3;  ///< rays per pixel and side of a camera pixel, 1 to 8
  int refinement = 2;     ///< light transport cells per fitted voxel and side, 2 to 4
  TransportMethod transport = TransportMethod::diffusion;
  std::uint64_t photons =
      TransportChoice{}.photons;  ///< per pattern, Monte Carlo, 1000 to 2^32 − 1
  double anisotropy = 0.0;        ///< g of Monte Carlo's scattering, −0.95 to 0.95
  int holdout = 8;                ///< n × n held-out patches in the truth, 0 (none) to 16

  static std::vector<double> geometric_exposures(double first, double last, int count);
};

/// Throws InputError naming option, value and bound.
void validate(const SimulationOptions& options);

}  // namespace kappamu::synthetic
