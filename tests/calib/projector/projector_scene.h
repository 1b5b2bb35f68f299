// A camera, a projector beside it, and planes that carry a printed and a projected board, by
// geometry alone.
#pragma once

#include <random>
#include <vector>

#include "calib/projector/projector.h"
#include "tests/calib/board_scene.h"

namespace kappamu::calib::testing {

struct ProjectorScene {
  static constexpr double square_mm = 4.0;
  Lens camera{1280, 960, 1700.0, 1702.0, 641.0, 476.0, {-0.1, 0.05}};
  Lens projector{1024, 768, 1500.0, 1500.0, 500.0, 700.0, {}};
  Rigid projector_from_station;
  capture::Board printed{9, 6, square_mm};
  capture::ProjectedBoard projected{9, 6, 40.0, {500.0, 200.0}};

  ProjectorScene() {
    projector_from_station.rotation =
        Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix();
    projector_from_station.translation = {35.0, 25.0, 8.0};
  }

  std::vector<PlaneView> planes(int count, double noise_px, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::normal_distribution<double> noise(0.0, noise_px);
    std::vector<PlaneView> views;
    for (int p = 0; p < count; ++p) {
      const Rigid pose = tilted(0.5 * unit(random), 0.5 * unit(random), 0.1 * unit(random),
                                {-18.0, 4.0 * unit(random), 160.0 + 15.0 * unit(random)},
                                {0.5 * square_mm * 8, 0.5 * square_mm * 5, 0.0});
      PlaneView view;
      view.name = "plane";
      view.printed = seen(camera, pose, 9, 6, square_mm, noise_px, random).corners;
      view.projected = {9, 6, {}};
      const Rigid projector_from_plane = projector_from_station * pose;
      for (int j = 0; j < 6; ++j) {
        for (int i = 0; i < 9; ++i) {
          const Eigen::Vector2d pixel(500.0 + 40.0 * i, 200.0 + 40.0 * j);
          const Eigen::Vector3d point = meet_plane(projector, projector_from_plane, pixel);
          Eigen::Vector2d seen_at = camera.project(pose * point);
          seen_at += Eigen::Vector2d(noise(random), noise(random));
          view.projected.pixels.push_back(seen_at);
        }
      }
      views.push_back(view);
    }
    return views;
  }
};

}  // namespace kappamu::calib::testing
