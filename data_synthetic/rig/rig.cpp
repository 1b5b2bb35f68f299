#include "data_synthetic/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/projector/projector.h"
#include "calib/targets/board_shape.h"
#include "core/error.h"
#include "data_synthetic/scene/random.h"

namespace kappamu::synthetic {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double radians(double degrees) {
  return degrees * std::numbers::pi / 180.0;
}

Matrix3d rotation(double x_degrees, double y_degrees, double z_degrees) {
  return (AngleAxisd(radians(x_degrees), Vector3d::UnitX()) *
          AngleAxisd(radians(y_degrees), Vector3d::UnitY()) *
          AngleAxisd(radians(z_degrees), Vector3d::UnitZ()))
      .toRotationMatrix();
}

/// Uniform in [-1, 1] by counters.
double jitter(std::uint64_t seed, std::uint64_t what, std::uint64_t index = 0) {
  return 2.0 * uniform(key_of({seed, what, index})) - 1.0;
}

enum Imperfection : std::uint64_t {
  sample_tilt = 101,
  sample_shift,
  station_angle,
  board_tilt,
  plane_tilt,
  plane_depth
};

/// World pose of a camera at `position` looking at `target`, upright (its y down) but for `roll`.
Rigid look_at(const Vector3d& position, const Vector3d& target, double roll_degrees) {
  const Vector3d forward = (target - position).normalized();
  const Vector3d right = Vector3d::UnitY().cross(forward).normalized();
  Rigid world_from_camera;
  world_from_camera.rotation.col(0) = right;
  world_from_camera.rotation.col(1) = forward.cross(right);
  world_from_camera.rotation.col(2) = forward;
  world_from_camera.rotation = world_from_camera.rotation * rotation(0, 0, roll_degrees);
  world_from_camera.translation = position;
  return world_from_camera;
}

constexpr double camera_focal_widths = 3.0;     // focal length over picture width
constexpr double projector_focal_widths = 3.5;  // the same of the projector

calib::Lens camera_lens(int width, int height) {
  calib::Lens lens;
  lens.width = width;
  lens.height = height;
  lens.fx = camera_focal_widths * width;
  lens.fy = 1.001 * lens.fx;
  lens.cx = 0.5 * (width - 1) + 0.009 * width;
  lens.cy = 0.5 * (height - 1) - 0.011 * height;
  lens.distortion = {-0.30, 0.8, 0.0008, -0.0006, 0.0};
  return lens;
}

calib::Lens projector_lens(int width, int height) {
  calib::Lens lens;
  lens.width = width;
  lens.height = height;
  lens.fx = projector_focal_widths * width;
  lens.fy = 0.9985 * lens.fx;
  lens.cx = 0.5 * (width - 1) - 0.006 * width;
  lens.cy = 0.5 * (height - 1) + 0.012 * height;
  lens.distortion = {0.18, -0.5, -0.0005, 0.0007, 0.0};
  return lens;
}

std::array<int, 2> default_camera_size(const std::string& sample) {
  if (sample == "demo") return {640, 480};
  if (sample == "tiny") return {400, 300};
  return {1280, 960};
}

calib::BoardShape shape_of(const capture::Board& board) {
  return {board.columns, board.rows, board.square_mm,
          board.kind == capture::BoardKind::asymmetric_circles};
}

/// The printed board: 9 x 6, or as large a staggered grid.
capture::Board printed_board(capture::BoardKind kind, double size_mm) {
  const auto rounded = [size_mm](double part) {
    return std::round(part * size_mm * 100.0) / 100.0;
  };
  capture::Board board{9, 6, rounded(0.09)};
  board.kind = kind;
  if (kind == capture::BoardKind::asymmetric_circles) {
    board.columns = 5;
    board.rows = 7;
    board.square_mm = rounded(0.08);
  }
  if (kind == capture::BoardKind::charuco) {
    board.marker_mm = 0.6 * board.square_mm;
    board.dictionary = "DICT_4X4_50";
  }
  return board;
}

/// Whether the whole printed board, margin included, is well inside the picture.
bool board_in_view(const calib::Lens& lens, const capture::Board& board,
                   const Rigid& camera_from_board) {
  const double low = -1.6 * board.square_mm;
  const Vector3d last = shape_of(board).flat_point(board.columns - 1, board.rows - 1);
  const double high_x = last.x() + 1.6 * board.square_mm;
  const double high_y = last.y() + 1.6 * board.square_mm;
  for (const Vector3d& corner : {Vector3d(low, low, 0), Vector3d(high_x, low, 0),
                                 Vector3d(low, high_y, 0), Vector3d(high_x, high_y, 0)}) {
    const Vector3d seen = camera_from_board * corner;
    if (seen.z() <= 0.0 || !lens.contains(lens.project(seen), 0.012 * lens.width)) return false;
  }
  return true;
}

/// The board over the nine fields of the picture by turns, tilted up to 35° about both axes.
std::vector<Rigid> camera_board_poses(const Rig& rig, int count, std::uint64_t seed) {
  std::vector<Rigid> poses;
  const capture::Board& board = rig.board;
  const Vector3d middle = 0.5 * shape_of(board).flat_point(board.columns - 1, board.rows - 1);
  const double board_width = 2.0 * middle.x() + 2.0 * board.square_mm;
  for (int view = 0; view < count; ++view) {
    const auto i = static_cast<std::uint64_t>(view);
    const Matrix3d turn =
        rotation(35.0 * jitter(seed, board_tilt, 4 * i), 35.0 * jitter(seed, board_tilt, 4 * i + 1),
                 15.0 * jitter(seed, board_tilt, 4 * i + 2));
    Vector2d field(view % 3 - 1, view / 3 % 3 - 1);
    double fraction = 0.50 + 0.12 * jitter(seed, board_tilt, 4 * i + 3);  // of the picture's width
    Rigid pose;
    for (int attempt = 0; attempt < 40; ++attempt) {
      const double distance = board_width * camera_focal_widths / fraction;
      const Vector2d pixel(rig.camera_lens.width * (0.5 + 0.36 * field.x()),
                           rig.camera_lens.height * (0.5 + 0.36 * field.y()));
      pose.rotation = turn;
      pose.translation = distance * rig.camera_lens.unproject(pixel) - turn * middle;
      if (board_in_view(rig.camera_lens, board, pose)) break;
      field *= 0.96;
      if (attempt % 6 == 5) fraction *= 0.95;
    }
    check(board_in_view(rig.camera_lens, board, pose), "a board pose lies in the picture");
    poses.push_back(pose);
  }
  return poses;
}

/// Whether the camera sees the printed and the projected board on a plane.
bool plane_in_view(const Rig& rig, const Rigid& world_from_plane) {
  const Rigid camera_from_plane =
      rig.world_from_camera.at(front_station).inverse() * world_from_plane;
  if (!board_in_view(rig.camera_lens, rig.board, camera_from_plane * rig.plane_from_board)) {
    return false;
  }
  const capture::ProjectedBoard& board = rig.projected_board;
  const Rigid projector_from_plane = rig.projector.projector_from_world * world_from_plane;
  const double right = board.columns + 1.0;  // squares, with one of white around
  const double bottom = board.rows + 1.0;
  for (const Vector2d& corner : {Vector2d(-2.0, -2.0), Vector2d(right, -2.0),
                                 Vector2d(-2.0, bottom), Vector2d(right, bottom)}) {
    const Vector2d pixel =
        Vector2d(board.origin_px[0], board.origin_px[1]) + board.square_px * corner;
    const Vector3d at = calib::meet_plane(rig.projector.lens, projector_from_plane, pixel);
    const Vector3d seen = camera_from_plane * at;
    if (!rig.camera_lens.contains(rig.camera_lens.project(seen), 0.012 * rig.camera_lens.width)) {
      return false;
    }
  }
  return true;
}

/// Planes about the place of the lit face, tilted up to 28° about both axes, at several depths.
std::vector<Rigid> projector_plane_poses(const Rig& rig, int count, std::uint64_t seed) {
  std::vector<Rigid> poses;
  const Vector3d pivot(-0.4 * rig.size_mm, 0.0, 0.0);
  for (int plane = 0; plane < count; ++plane) {
    const auto i = static_cast<std::uint64_t>(plane);
    const double angle = 2.0 * std::numbers::pi * plane / count + 0.3 * jitter(seed, plane_tilt, i);
    double amount = 1.0;
    Rigid pose;
    for (int attempt = 0; attempt < 40; ++attempt) {
      pose.rotation = rotation(28.0 * amount * std::sin(angle), 28.0 * amount * std::cos(angle),
                               6.0 * amount * jitter(seed, plane_tilt, i + 500));
      pose.translation = pivot - pose.rotation * pivot;
      pose.translation.z() += 0.35 * amount * rig.size_mm * jitter(seed, plane_depth, i);
      if (plane_in_view(rig, pose)) break;
      amount *= 0.9;
    }
    check(plane_in_view(rig, pose), "a projector plane lies in the picture");
    poses.push_back(pose);
  }
  return poses;
}

void place_boards(Rig& rig, const SimulationOptions& options) {
  const double s = rig.size_mm;
  rig.board = printed_board(options.board, s);
  // Squares end between pixels, so that a corner's position in projector pixels is a half-integer.
  const double square_px = std::round(0.0575 * rig.projector_size.width);
  const auto origin = [&](double middle, int corners) {
    return std::floor(middle - 0.5 * (corners - 1) * square_px) + 0.5;
  };
  rig.projected_board = {
      9,
      6,
      square_px,
      {origin(0.53 * rig.projector_size.width, 9), origin(0.5 * rig.projector_size.height, 6)}};
  const double square = rig.board.square_mm;
  const Vector3d last = shape_of(rig.board).flat_point(rig.board.columns - 1, rig.board.rows - 1);
  rig.plane_from_board.translation = {-0.72 * s - last.x() - 1.6 * square, -0.5 * last.y(), -1e-3};
  rig.camera_from_board = camera_board_poses(rig, options.board_views, options.seed);
  rig.world_from_plane = projector_plane_poses(rig, options.projector_planes, options.seed);
}

}  // namespace

Rigid Rig::world_from_target() const {
  Rigid sample_from_target;
  sample_from_target.translation = {0.5 * sample.grid.nx * sample.grid.voxel_mm,
                                    0.5 * sample.grid.ny * sample.grid.voxel_mm, 0.0};
  return world_from_sample * sample_from_target;
}

Rig make_rig(const SimulationOptions& options) {
  Rig rig;
  rig.sample = make_sample(options.sample, options.seed, options.grid);
  rig.two_stations = options.both_faces;
  const GridShape& grid = rig.sample.grid;
  const Vector3d extent = Vector3d(grid.nx, grid.ny, grid.nz) * grid.voxel_mm;
  rig.size_mm = std::max(extent.x(), extent.y() * 4.0 / 3.0);
  const double s = rig.size_mm;
  const std::uint64_t seed = options.seed;

  rig.projector_size = {options.projector_size[0], options.projector_size[1]};
  rig.projector.gamma = options.projector_gamma;
  rig.projector.lens = projector_lens(rig.projector_size.width, rig.projector_size.height);
  rig.projector.projector_from_world.translation = {0.0, 0.0, 2.0 * projector_focal_widths * s};

  const std::array<int, 2> size = options.camera_size.value_or(default_camera_size(options.sample));
  rig.camera_lens = camera_lens(size[0], size[1]);
  const double front_distance = 2.9 * camera_focal_widths * s;
  const double front_angle = radians(17.0 + 0.7 * jitter(seed, station_angle));
  const Vector3d aim(-0.53 * s, 0.0, 0.0);
  rig.world_from_camera[front_station] = look_at(
      aim + front_distance * Vector3d(-std::sin(front_angle), -0.05, -std::cos(front_angle)), aim,
      0.6 * jitter(seed, station_angle, 1));
  const double side_angle = radians(22.0 + 0.7 * jitter(seed, station_angle, 3));
  const double side_distance = 1.6 * camera_focal_widths * s;
  rig.world_from_camera[side_station] =
      look_at(side_distance * Vector3d(std::sin(side_angle), 0.04, -std::cos(side_angle)),
              Vector3d::Zero(), 0.8 * jitter(seed, station_angle, 4));
  const Vector3d back_centre(0.0, 0.0, extent.z());
  const double back_distance = 1.4 * camera_focal_widths * s;
  rig.world_from_camera[back_station] =
      look_at(back_centre + back_distance * Vector3d(0.03, -0.02, 1.0), back_centre,
              1.0 * jitter(seed, station_angle, 2));

  rig.world_from_sample.rotation =
      rotation(1.0 * jitter(seed, sample_tilt), 1.0 * jitter(seed, sample_tilt, 1),
               0.7 * jitter(seed, sample_tilt, 2));
  const Vector3d middle(0.5 * extent.x(), 0.5 * extent.y(), 0.0);
  rig.world_from_sample.translation =
      Vector3d(0.006 * s * jitter(seed, sample_shift), 0.006 * s * jitter(seed, sample_shift, 1),
               0.01 * s * jitter(seed, sample_shift, 2)) -
      rig.world_from_sample.rotation * middle;
  set_white_reference(rig.projector, rig.world_from_sample * middle,
                      -rig.world_from_sample.rotation.col(2));

  rig.sensor.bit_depth = options.bit_depth;
  rig.sensor.encoding = options.encoding;
  rig.sensor.noise_scale = options.noise_scale;
  rig.sensor.seed = seed;
  place_boards(rig, options);
  return rig;
}

void choose_gain(Rig& rig, double brightest, double exposure_s) {
  const double most = *std::max_element(rig.responsivity.begin(), rig.responsivity.end());
  const double scale = 1.0 / (brightest * exposure_s * most);
  for (double& value : rig.responsivity) value *= scale;
}

}  // namespace kappamu::synthetic
