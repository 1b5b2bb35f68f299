#include "studies/calibration/rig_corners.h"

namespace kappamu::studies {

calib::BoardView seen_board(const calib::Lens& camera, const capture::Board& board,
                            const Rigid& camera_from_board, double noise_px,
                            std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, noise_px);
  calib::BoardView view{"view", {board.columns, board.rows, {}}};
  for (int j = 0; j < board.rows; ++j) {
    for (int i = 0; i < board.columns; ++i) {
      const Eigen::Vector3d corner(board.square_mm * i, board.square_mm * j, 0.0);
      view.corners.pixels.push_back(camera.project(camera_from_board * corner) +
                                    Eigen::Vector2d(noise(random), noise(random)));
    }
  }
  return view;
}

RigCorners seen_corners(const synthetic::Rig& rig, double noise_px, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, noise_px);
  const calib::Lens& camera = rig.camera_lens;
  const Rigid camera_from_world = rig.world_from_camera.at(synthetic::front_station).inverse();
  RigCorners corners;
  for (const Rigid& pose : rig.camera_from_board) {
    corners.views.push_back(seen_board(camera, rig.board, pose, noise_px, random));
  }
  for (const Rigid& world_from_plane : rig.world_from_plane) {
    const Rigid world_from_board = world_from_plane * rig.plane_from_board;
    const Rigid camera_from_board = camera_from_world * world_from_board;
    corners.views.push_back(seen_board(camera, rig.board, camera_from_board, noise_px, random));
    const capture::ProjectedBoard& shown = rig.projected_board;
    calib::PlaneView plane{"plane", corners.views.back().corners, {shown.columns, shown.rows, {}}};
    for (int k = 0; k < shown.columns * shown.rows; ++k) {
      const Eigen::Vector2d pixel =
          calib::projector_pixel(shown, plane.projected, static_cast<std::size_t>(k));
      const Eigen::Vector3d point = calib::meet_plane(
          rig.projector.lens, rig.projector.projector_from_world * world_from_board, pixel);
      plane.projected.pixels.push_back(camera.project(camera_from_board * point) +
                                       Eigen::Vector2d(noise(random), noise(random)));
    }
    corners.planes.push_back(plane);
  }
  return corners;
}

}  // namespace kappamu::studies
