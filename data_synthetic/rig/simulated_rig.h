// The simulated rig behind the interface that real rigs implement.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/rig/device.h"
#include "core/progress.h"
#include "data_synthetic/rig/render.h"
#include "data_synthetic/rig/rig.h"
#include "data_synthetic/transport.h"

namespace kappamu::synthetic {

class SimulatedRig final : public capture::RigDevice {
 public:
  /// `device` selects where light transport is computed (forward/grid/grid_solver.h).
  SimulatedRig(const SimulationOptions& options, const std::string& device);

  /// Solves light transport for the images a session will show, together, and sets the camera's
  /// gain by their radiance, as one sets an aperture: the brightest scattered light fills two
  /// thirds of full scale in the shortest exposure, where light falls on the seen face itself
  /// leaving that out. Room light is set so that white paper reaches 0.7 full scales in the second
  /// exposure. Images shown later without having been prepared are solved on their own.
  void prepare(const std::vector<Image<std::uint8_t>>& images, Progress& progress);

  capture::Camera camera() const override;
  capture::Projector projector() const override;
  void place(const capture::Scene& scene) override;
  void show(const Image<std::uint8_t>& image) override;
  Image<std::uint16_t> expose(double exposure_s) override;

  const Rig& rig() const { return rig_; }
  const Transport& transport() const { return *transport_; }
  Transport& transport() { return *transport_; }
  const std::array<Medium, 3>& media() const { return media_; }  ///< on the transport grid

  /// Irradiance [v][u] on the lit face's cells of the transport grid.
  std::vector<double> lit_face_irradiance(const Image<std::uint8_t>& image) const;
  /// Noise-free picture [y][x][RGB] of the sample under an image, from the pattern station, in full
  /// scales per second; with `lit_face` from the calibration station.
  Image<float> sample_radiance(const Image<std::uint8_t>& image, bool lit_face = false);
  /// Exposure time [s] in which the brightest channel of the white target, under full white,
  /// reaches `signal` full scales.
  double white_exposure_s(double signal) const;

  /// Exitance [channel][v][u] on a face's cells of the transport grid.
  using ExitanceMaps = std::vector<std::vector<double>>;
  const ExitanceMaps& exitance(const Image<std::uint8_t>& image, Face face) const;
  /// Of the lit face's surface at a place of it [mm], R, G, B: smooth waves about the mean that the
  /// options state, that of green and blue 0.8 and 0.6 of red's.
  std::array<double, 3> surface_reflectance(const Eigen::Vector2d& at_mm) const;

 private:
  const RayTable& rays();
  Image<float> picture();
  /// Those that patterns are photographed on.
  std::vector<Face> photographed() const;
  double room_light() const;  ///< of the present scene, in the dark
  Image<float> to_full_scales(Image<float> radiance) const;
  /// Radiance of the projector's light that the lit face's surface reflects.
  Image<float> reflected(const Image<std::uint8_t>& image, const std::string& station);
  void solve(const std::vector<Image<std::uint8_t>>& images, Progress& progress);

  Rig rig_;
  SimulationOptions options_;
  double ambient_ = 0.0;
  std::unique_ptr<Transport> transport_;
  std::array<Medium, 3> media_;
  std::map<std::pair<std::string, Face>, ExitanceMaps> solved_;  ///< by the image's pixels
  std::unique_ptr<RayTable> rays_;
  std::map<std::string, FaceView> face_views_;  ///< by station
  capture::Scene scene_;
  Image<std::uint8_t> shown_;
  std::optional<Image<float>> picture_;  ///< of the present scene and image
  std::uint64_t frames_ = 0;
  int patterns_shown_ = 0;  ///< on the sample so far
};

}  // namespace kappamu::synthetic
