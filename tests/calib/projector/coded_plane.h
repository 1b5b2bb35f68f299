// A plane of the simulated rig under projected codes, and where its points truly are.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "calib/projector/projector.h"
#include "calib/projector/projector_map.h"
#include "calib/targets/chessboard.h"
#include "data_synthetic/rig/render.h"
#include "data_synthetic/rig/rig.h"
#include "data_synthetic/rig/targets.h"
#include "tests/calib/board_scene.h"

namespace kappamu::calib::testing {

/// The tiny rig's camera looking at one of its planes under the images, with a session's noise.
inline std::vector<Image<float>> photographs(const synthetic::Rig& rig,
                                             const Rigid& world_from_plane,
                                             const std::vector<Image<std::uint8_t>>& images,
                                             unsigned seed) {
  const synthetic::RayTable rays(rig.camera_lens, 2);
  const synthetic::Quad plane =
      synthetic::plain_quad(Eigen::Vector2d::Constant(6.0 * rig.size_mm), 0.85, world_from_plane);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, 1.0F);
  std::vector<Image<float>> frames;
  for (const Image<std::uint8_t>& shown : images) {
    Image<float> light(shown.width(), shown.height(), 1);
    for (std::size_t k = 0; k < shown.size(); ++k) {
      light.values()[k] = static_cast<float>(shown.values()[k]) / 255.0F;
    }
    const Image<float> thrown = synthetic::thrown_image(rig.projector, light);
    synthetic::Illumination illumination;
    illumination.projector = &rig.projector;
    illumination.thrown = &thrown;
    frames.push_back(to_grey(synthetic::render_quads(
        rays, rig.world_from_camera.at(synthetic::front_station), {plane}, illumination)));
    for (float& value : frames.back().values()) {
      value += (0.0007F + 0.005F * std::sqrt(std::max(value, 0.0F))) * noise(random);
    }
  }
  return frames;
}

/// Frames that are in memory.
inline FrameSource held(std::vector<Image<float>> frames) {
  return [all = std::move(frames)](std::size_t n) { return all.at(n); };
}

struct Misses {
  std::size_t points = 0;
  double rms_px = 0.0, largest_px = 0.0;  ///< in the camera's picture
};

/// Of the located points from where the projector throws them.
inline Misses misses(const synthetic::Rig& rig, const Rigid& world_from_plane,
                     const capture::ProjectedBoard& lattice, const BoardCorners& corners) {
  const Rigid projector_from_plane = rig.projector.projector_from_world * world_from_plane;
  const Rigid camera_from_plane =
      rig.world_from_camera.at(synthetic::front_station).inverse() * world_from_plane;
  Misses found{corners.pixels.size()};
  double sum = 0.0;
  for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
    const auto [i, j] = corners.place(k);
    const Eigen::Vector2d shown(lattice.origin_px[0] + lattice.square_px * i,
                                lattice.origin_px[1] + lattice.square_px * j);
    const Eigen::Vector3d point = meet_plane(rig.projector.lens, projector_from_plane, shown);
    const double miss =
        (rig.camera_lens.project(camera_from_plane * point) - corners.pixels[k]).norm();
    sum += miss * miss;
    found.largest_px = std::max(found.largest_px, miss);
  }
  found.rms_px = std::sqrt(sum / static_cast<double>(corners.pixels.size()));
  return found;
}

}  // namespace kappamu::calib::testing
