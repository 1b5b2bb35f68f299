// Boards seen through a known lens: exact corners, and pictures of them by ray casting. Independent
// of OpenCV, so that what is found can be held against what was drawn.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "calib/lens/camera.h"
#include "calib/targets/board_shape.h"
#include "core/image.h"

namespace kappamu::calib::testing {

/// A pose in front of the camera, tilted about x and y and turned about z (radians), the board's
/// middle at `centre` [mm].
inline Rigid tilted(double about_x, double about_y, double about_z, const Eigen::Vector3d& centre,
                    const Eigen::Vector3d& middle_of_board) {
  Rigid pose;
  pose.rotation = (Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(about_z, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation = centre - pose.rotation * middle_of_board;
  return pose;
}

/// Twelve board poses over the frame, tilted up to 30 degrees.
inline std::vector<Rigid> board_poses(int columns, int rows, double square_mm, double distance_mm,
                                      std::mt19937& random) {
  std::vector<Rigid> poses;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Eigen::Vector3d middle(0.5 * square_mm * (columns - 1), 0.5 * square_mm * (rows - 1), 0.0);
  for (int view = 0; view < 12; ++view) {
    const double tilt_x = 0.5 * unit(random);
    const double tilt_y = 0.5 * unit(random);
    const double turn = 0.2 * unit(random);
    const double depth = distance_mm * (1.0 + 0.1 * unit(random));
    const Eigen::Vector3d centre(0.12 * distance_mm * unit(random),
                                 0.1 * distance_mm * unit(random), depth);
    poses.push_back(tilted(tilt_x, tilt_y, turn, centre, middle));
  }
  return poses;
}

/// Exact corners plus Gaussian noise; the sheet may be bent (board_shape.h).
inline BoardView seen(const Lens& lens, const Rigid& camera_from_board, int columns, int rows,
                      double square_mm, double noise_px, std::mt19937& random,
                      const std::array<double, 2>& bend_mm = {}) {
  std::normal_distribution<double> noise(0.0, 1.0);
  BoardView view;
  view.name = "synthetic";
  view.corners = {columns, rows, {}};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector3d corner =
          bent_corner<double>({columns, rows, square_mm}, bend_mm.data(), i, j);
      Eigen::Vector2d pixel = lens.project(camera_from_board * corner);
      pixel.x() += noise_px * noise(random);
      pixel.y() += noise_px * noise(random);
      view.corners.pixels.push_back(pixel);
    }
  }
  return view;
}

/// A picture by 4 x 4 jittered rays per pixel (on a regular lattice, edges along the pixel grid
/// would sit up to 1/8 px wrong): black and white squares on a white sheet one square wider
/// than the board all round, mid-grey beyond.
inline Image<float> photograph(const Lens& lens, const Rigid& camera_from_board, int columns,
                               int rows, double square_mm, double noise, std::mt19937& random) {
  Image<float> image(lens.width, lens.height, 1);
  const Rigid board_from_camera = camera_from_board.inverse();
  std::normal_distribution<float> grain(0.0F, 1.0F);
  std::uniform_real_distribution<double> jitter(0.0, 1.0);
  constexpr int rays = 4;
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      double sum = 0.0;
      for (int ray = 0; ray < rays * rays; ++ray) {
        const Eigen::Vector2d pixel(x + (ray % rays + jitter(random)) / rays - 0.5,
                                    y + (ray / rays + jitter(random)) / rays - 0.5);
        const Eigen::Vector3d direction = board_from_camera.rotation * lens.unproject(pixel);
        const Eigen::Vector3d& eye = board_from_camera.translation;
        const Eigen::Vector3d point = eye - direction * (eye.z() / direction.z());
        const double u = point.x() / square_mm;
        const double v = point.y() / square_mm;
        if (u < -2.0 || v < -2.0 || u > columns + 1.0 || v > rows + 1.0) {
          sum += 0.3;
        } else if (u < -1.0 || v < -1.0 || u > columns || v > rows) {
          sum += 0.9;
        } else {
          const int parity =
              (static_cast<int>(std::floor(u)) + static_cast<int>(std::floor(v))) & 1;
          sum += parity == 0 ? 0.05 : 0.9;
        }
      }
      image(x, y) =
          static_cast<float>(sum / (rays * rays)) + static_cast<float>(noise) * grain(random);
    }
  }
  return image;
}

/// Convolved with a Gaussian, rows then columns, edge pixels repeated.
inline Image<float> blurred(const Image<float>& image, double deviation_px) {
  if (deviation_px <= 0.0) return image;
  const int half = static_cast<int>(std::ceil(4.0 * deviation_px));
  std::vector<double> weights;
  double sum = 0.0;
  for (int k = -half; k <= half; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (deviation_px * deviation_px)));
    sum += weights.back();
  }
  const auto pass = [&](const Image<float>& in, int dx, int dy) {
    Image<float> out(in.width(), in.height(), 1);
    for (int y = 0; y < in.height(); ++y) {
      for (int x = 0; x < in.width(); ++x) {
        double value = 0.0;
        for (int k = -half; k <= half; ++k) {
          value += weights[static_cast<std::size_t>(k + half)] *
                   in(std::clamp(x + k * dx, 0, in.width() - 1),
                      std::clamp(y + k * dy, 0, in.height() - 1));
        }
        out(x, y) = static_cast<float>(value / sum);
      }
    }
    return out;
  };
  return pass(pass(image, 1, 0), 0, 1);
}

}  // namespace kappamu::calib::testing
