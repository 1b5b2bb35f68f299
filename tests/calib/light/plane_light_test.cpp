// What a projector calibration is worth from projected chessboards and from Gray codes, on the
// simulated rig's own planes, corners by geometry with the noise that rendered pictures show.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calib/projector/gray_code.h"
#include "calib/projector/projector.h"
#include "data_synthetic/rig/rig.h"
#include "tests/calib/board_scene.h"

namespace kappamu::calib {
namespace {

constexpr double corner_noise_px = 0.03;  // of printed and projected chessboards
constexpr double code_noise_px = 0.02;    // of a Gray code's points (gray_code_test.cpp)
constexpr std::size_t boards = 15;

/// Printed boards and planes of one photographed session; `shown` is the lattice thrown.
struct Shots {
  std::vector<BoardView> views;
  std::vector<PlaneView> planes;
};

Shots shots_of(const synthetic::Rig& rig, const capture::ProjectedBoard& shown, double noise_px,
               std::size_t planes, unsigned seed) {
  std::mt19937 random(seed);  // the printed boards first: the same for every lattice
  std::normal_distribution<double> noise(0.0, noise_px);
  const Rigid camera_from_world = rig.world_from_camera.at(synthetic::front_station).inverse();
  Shots shots;
  const auto add_view = [&](const Rigid& pose) {
    shots.views.push_back(testing::seen(rig.camera_lens, pose, rig.board.columns, rig.board.rows,
                                        rig.board.square_mm, corner_noise_px, random));
  };
  for (std::size_t v = 0; v < boards; ++v) add_view(rig.camera_from_board[v]);
  for (std::size_t p = 0; p < planes; ++p) {
    add_view(camera_from_world * rig.world_from_plane[p] * rig.plane_from_board);
  }
  for (std::size_t p = 0; p < planes; ++p) {
    const Rigid camera_from_plane = camera_from_world * rig.world_from_plane[p];
    const Rigid projector_from_plane = rig.projector.projector_from_world * rig.world_from_plane[p];
    PlaneView plane{"plane", shots.views[boards + p].corners, {shown.columns, shown.rows, {}}};
    for (int k = 0; k < shown.columns * shown.rows; ++k) {
      const Eigen::Vector2d pixel(shown.origin_px[0] + shown.square_px * (k % shown.columns),
                                  shown.origin_px[1] + shown.square_px * (k / shown.columns));
      const Eigen::Vector2d seen = rig.camera_lens.project(
          camera_from_plane * meet_plane(rig.projector.lens, projector_from_plane, pixel));
      if (!rig.camera_lens.contains(seen)) continue;
      plane.projected.lattice.push_back(k);
      plane.projected.pixels.push_back(seen + Eigen::Vector2d(noise(random), noise(random)));
    }
    shots.planes.push_back(plane);
  }
  return shots;
}

/// Sums of squares over runs.
struct Errors {
  double face_px = 0.0;
  double focal = 0.0;
  double centre_px = 0.0;
  double stated_focal = 0.0;
};

void add_errors(const synthetic::Rig& rig, const capture::ProjectedBoard& shown, double noise_px,
                std::size_t planes, unsigned seed, Errors& sums) {
  const Shots shots = shots_of(rig, shown, noise_px, planes, seed);
  const Lens& eye = rig.camera_lens;
  const CameraCalibration camera =
      calibrate_camera(shots.views, rig.board.square_mm, eye.width, eye.height);
  const ProjectorCalibration found =
      calibrate_projector(camera.lens, rig.board, shown, shots.planes, rig.projector_size.width,
                          rig.projector_size.height);
  const Rigid world_from_camera = rig.world_from_camera.at(synthetic::front_station);
  // The sample's pose comes from the found lens, as in a session: much of its error cancels.
  BoardCorners face{3, 3, {}};
  const double spacing_mm = 0.4 * rig.size_mm;
  const Rigid world_from_board =
      rig.world_from_target() * Rigid{Eigen::Matrix3d::Identity(), {-spacing_mm, -spacing_mm, 0.0}};
  const BoardShape shape{face.columns, face.rows, spacing_mm};
  constexpr std::size_t points = 9;
  for (std::size_t k = 0; k < points; ++k) {
    const Eigen::Vector3d in_world =
        world_from_board * shape.flat_point(static_cast<int>(k % 3), static_cast<int>(k / 3));
    face.pixels.push_back(eye.project(world_from_camera.inverse() * in_world));
  }
  const Rigid camera_from_board = board_pose(camera.lens, face, spacing_mm, "lit face");
  double face_square = 0.0;
  for (std::size_t k = 0; k < points; ++k) {
    const Eigen::Vector3d on_board =
        shape.flat_point(static_cast<int>(k % 3), static_cast<int>(k / 3));
    const Eigen::Vector3d in_camera = camera_from_board * on_board;
    face_square += (found.lens.project(found.projector_from_station * in_camera) -
                    rig.projector.lens.project(rig.projector.projector_from_world *
                                               (world_from_board * on_board)))
                       .squaredNorm() /
                   points;
  }
  sums.face_px += face_square;
  sums.focal += std::pow(found.lens.fx / rig.projector.lens.fx - 1.0, 2);
  sums.centre_px += std::pow(found.lens.cx - rig.projector.lens.cx, 2) +
                    std::pow(found.lens.cy - rig.projector.lens.cy, 2);
  sums.stated_focal += found.covariance(0, 0) / std::pow(rig.projector.lens.fx, 2);
}

// The code reaches over the projector's whole frame and has ten times the points. At the lit face
// that is worth nothing: the error there is the camera's, which both share.
TEST(PlaneLight, GrayCodeTellsTheProjectorsLensBetter) {
  constexpr int runs = 4;
  std::printf("planes  light       lit face px  focal %%  (stated)  principal point px\n");
  for (const std::size_t planes : {std::size_t{6}}) {
    std::array<Errors, 2> sums;
    for (int run = 0; run < runs; ++run) {
      synthetic::SimulationOptions options;
      options.seed = static_cast<std::uint64_t>(run) + 1;
      const synthetic::Rig rig = synthetic::make_rig(options);
      const unsigned seed = 100 + static_cast<unsigned>(run);
      add_errors(rig, rig.projected_board, corner_noise_px, planes, seed, sums[0]);
      add_errors(rig, map_lattice(rig.projector_size), code_noise_px, planes, seed, sums[1]);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      std::printf("%4zu    %s  %10.3f  %8.3f  (%.3f)  %10.2f\n", planes,
                  k == 0 ? "chessboard" : "gray code ", std::sqrt(sums[k].face_px / runs),
                  100.0 * std::sqrt(sums[k].focal / runs),
                  100.0 * std::sqrt(sums[k].stated_focal / runs),
                  std::sqrt(sums[k].centre_px / runs));
    }
    EXPECT_LT(sums[1].focal, sums[0].focal);
    EXPECT_LT(sums[1].centre_px, sums[0].centre_px);
    for (const Errors& sum : sums) EXPECT_LT(std::sqrt(sum.face_px / runs), 0.25);
  }
}

}  // namespace
}  // namespace kappamu::calib
