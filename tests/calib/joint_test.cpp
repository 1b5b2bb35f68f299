// The joint adjustment against the sequential calibration and against its own covariance, on the
// simulated rig's own boards and planes, corners by geometry.
#include "calib/joint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "board_scene.h"
#include "calib/projection_uncertainty.h"
#include "data_synthetic/rig.h"

namespace kappamu::calib {
namespace {

constexpr double corner_noise_px = 0.03;  // what rendered pictures of a default session show

/// What a session's boards and planes show, and where they truly stand.
struct Shots {
  std::vector<BoardView> views;
  std::vector<PlaneView> planes;
  std::vector<Rigid> poses;
};

Shots shots_of(const synthetic::Rig& rig, std::mt19937& random, std::size_t boards,
               std::size_t plane_count) {
  std::normal_distribution<double> noise(0.0, corner_noise_px);
  Shots shots;
  const Rigid camera_from_world = rig.world_from_camera.at(synthetic::front_station).inverse();
  const auto add = [&](const Rigid& pose) {
    shots.poses.push_back(pose);
    shots.views.push_back(testing::seen(rig.camera_lens, pose, rig.board.columns, rig.board.rows,
                                        rig.board.square_mm, corner_noise_px, random));
  };
  for (std::size_t v = 0; v < boards; ++v) add(rig.camera_from_board[v]);
  for (std::size_t p = 0; p < plane_count; ++p) {
    const Rigid camera_from_plane = camera_from_world * rig.world_from_plane[p];
    add(camera_from_plane * rig.plane_from_board);
    const Rigid projector_from_board =
        rig.projector.projector_from_world * rig.world_from_plane[p] * rig.plane_from_board;
    PlaneView plane;
    plane.name = "plane";
    plane.printed = shots.views.back().corners;
    plane.projected = {rig.projected_board.columns, rig.projected_board.rows, {}};
    for (int k = 0; k < rig.projected_board.columns * rig.projected_board.rows; ++k) {
      const Eigen::Vector2d shown =
          projector_pixel(rig.projected_board, plane.projected, static_cast<std::size_t>(k));
      const Eigen::Vector3d point = meet_plane(rig.projector.lens, projector_from_board, shown);
      plane.projected.pixels.push_back(rig.camera_lens.project(shots.poses.back() * point) +
                                       Eigen::Vector2d(noise(random), noise(random)));
    }
    shots.planes.push_back(plane);
  }
  return shots;
}

struct Both {
  CameraCalibration camera;
  ProjectorCalibration projector;
  JointCalibration joint;
};

Both calibrated(const synthetic::Rig& rig, const Shots& shots, std::optional<LensModel> camera,
                std::optional<LensModel> projector) {
  const Lens& eye = rig.camera_lens;
  const Lens& light = rig.projector.lens;
  Both both;
  both.camera = calibrate_camera(shots.views, rig.board.square_mm, eye.width, eye.height, camera);
  both.projector = calibrate_projector(both.camera.lens, rig.board, rig.projected_board,
                                       shots.planes, light.width, light.height, projector);
  both.joint = adjust_jointly({shots.views, rig.board, rig.projected_board, shots.planes},
                              both.camera, both.projector);
  return both;
}

/// Points of the lit face's plane, over the projected board's place, in the camera's frame.
std::vector<Eigen::Vector3d> sample_points(const synthetic::Rig& rig) {
  std::vector<Eigen::Vector3d> points;
  const Rigid camera_from_world = rig.world_from_camera.at(synthetic::front_station).inverse();
  for (int k = 0; k < 9; ++k) {
    const Eigen::Vector3d in_target(0.5 * rig.size_mm * (k % 3 - 1),
                                    0.375 * rig.size_mm * (k / 3 - 1), 0.0);
    points.push_back(camera_from_world * rig.world_from_target() * in_target);
  }
  return points;
}

TEST(Joint, ExactCornersGiveTheExactRig) {
  const synthetic::Rig rig = synthetic::make_rig({});
  std::mt19937 random(1);
  Shots shots = shots_of(rig, random, 10, 6);
  for (std::size_t v = 0; v < shots.views.size(); ++v) {
    std::mt19937 unused(1);
    shots.views[v] =
        testing::seen(rig.camera_lens, shots.poses[v], 9, 6, rig.board.square_mm, 0.0, unused);
  }
  for (std::size_t p = 0; p < shots.planes.size(); ++p) {
    PlaneView& plane = shots.planes[p];
    plane.printed = shots.views[10 + p].corners;
    const Rigid projector_from_board =
        rig.projector.projector_from_world * rig.world_from_plane[p] * rig.plane_from_board;
    for (std::size_t k = 0; k < plane.projected.pixels.size(); ++k) {
      const Eigen::Vector2d shown = projector_pixel(rig.projected_board, plane.projected, k);
      plane.projected.pixels[k] = rig.camera_lens.project(
          shots.poses[10 + p] * meet_plane(rig.projector.lens, projector_from_board, shown));
    }
  }
  const Both both =
      calibrated(rig, shots, LensModel::radial2_tangential, LensModel::radial2_tangential);
  EXPECT_TRUE(both.joint.converged);
  EXPECT_NEAR(both.joint.camera.lens.fx, rig.camera_lens.fx, 1e-3);
  EXPECT_NEAR(both.joint.projector.lens.fx, rig.projector.lens.fx, 1e-2);
  const Rigid truth =
      rig.projector.projector_from_world * rig.world_from_camera.at(synthetic::front_station);
  EXPECT_LT((both.joint.projector.projector_from_station.translation - truth.translation).norm(),
            1e-3);
}

// Predicted against sampled spread at the sample, camera and projector; and whether the joint
// solution beats the sequential one.
void hold_against_samples(std::size_t boards, std::size_t planes, int runs, const char* name) {
  double joint_square = 0.0;
  double sequential_square = 0.0;
  double predicted = 0.0;
  double sequential_predicted = 0.0;
  double joint_camera = 0.0;
  double sequential_camera = 0.0;
  double camera_predicted = 0.0;
  double camera_sequential_predicted = 0.0;
  double focal = 0.0;
  double sequential_focal = 0.0;
  for (int run = 0; run < runs; ++run) {
    synthetic::SimulationOptions options;
    options.seed = 1 + static_cast<std::uint64_t>(run);
    const synthetic::Rig rig = synthetic::make_rig(options);
    std::mt19937 random(500 + run);
    const Shots shots = shots_of(rig, random, boards, planes);
    const Both both = calibrated(rig, shots, std::nullopt, std::nullopt);
    JointCalibration sequential{both.camera, both.projector, {}, 0.0, 0.0, true};
    const std::size_t first = shots.poses.size() - planes;
    for (std::size_t p = 0; p < planes; ++p) {
      sequential.camera.camera_from_board[first + p] = both.projector.station_from_plane[p];
    }
    for (const Eigen::Vector3d& point : sample_points(rig)) {
      const Eigen::Vector2d truth =
          rig.projector.lens.project(rig.projector.projector_from_world *
                                     rig.world_from_camera.at(synthetic::front_station) * point);
      joint_square += (lit_through_boards(both.joint, shots.poses, point) - truth).squaredNorm();
      sequential_square +=
          (lit_through_boards(sequential, shots.poses, point) - truth).squaredNorm();
      predicted += projector_covariance(both.joint, point).trace();
      const Eigen::Vector2d pixel = rig.camera_lens.project(point);
      joint_camera +=
          (projected_through_boards(both.joint.camera, shots.poses, point) - pixel).squaredNorm();
      sequential_camera +=
          (projected_through_boards(both.camera, shots.poses, point) - pixel).squaredNorm();
      camera_predicted += projection_covariance(both.joint.camera, pixel, point.z()).trace();
      camera_sequential_predicted += projection_covariance(both.camera, pixel, point.z()).trace();
    }
    focal += std::pow(both.joint.camera.lens.fx / rig.camera_lens.fx - 1.0, 2) / runs;
    sequential_focal += std::pow(both.camera.lens.fx / rig.camera_lens.fx - 1.0, 2) / runs;
  }
  (void)sequential_predicted;
  const double count = 9.0 * runs;
  std::printf(
      "%s: projector at the sample [px] joint %.3f (predicted %.3f), sequential %.3f; camera joint "
      "%.4f (predicted %.4f), sequential %.4f (predicted %.4f); focal joint %.4f %%, sequential "
      "%.4f %%\n",
      name, std::sqrt(joint_square / count), std::sqrt(predicted / count),
      std::sqrt(sequential_square / count), std::sqrt(joint_camera / count),
      std::sqrt(camera_predicted / count), std::sqrt(sequential_camera / count),
      std::sqrt(camera_sequential_predicted / count), 100.0 * std::sqrt(focal),
      100.0 * std::sqrt(sequential_focal));
  EXPECT_NEAR(std::sqrt(predicted / joint_square), 1.0, 0.25) << name;
  EXPECT_NEAR(std::sqrt(camera_predicted / joint_camera), 1.0, 0.25) << name;
}

TEST(Joint, SpreadAtTheSampleIsAsPredicted) {
  hold_against_samples(15, 10, 24, "15 boards, 10 planes");
}

}  // namespace
}  // namespace kappamu::calib
