#include "data_synthetic/rig/targets.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/targets/charuco.h"

namespace kappamu::synthetic {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// +1 or −1 by turns on unit intervals, +1 on [0, 1), averaged near its jumps over `width`.
double square_wave(double x, double width) {
  const double edge = std::round(x);
  const double right_of_edge = std::fmod(std::abs(edge), 2.0) < 0.5 ? 1.0 : -1.0;
  return right_of_edge * std::clamp(2.0 * (x - edge) / width, -1.0, 1.0);
}

/// Blackness in [0, 1] of the chessboard at `position` in squares from inner corner (0, 0).
double chessboard_ink(const Vector2d& position, int columns, int rows, const Vector2d& width) {
  const double on_board = coverage(position.x(), -1.0, columns, width.x()) *
                          coverage(position.y(), -1.0, rows, width.y());
  const double pattern =
      square_wave(position.x(), width.x()) * square_wave(position.y(), width.y());
  return on_board * (0.5 + 0.5 * pattern);
}

/// The same of the dots of a circle grid: a disc's edge averaged along the radius.
double dot_ink(const Vector2d& position, const capture::Board& board, const Vector2d& width) {
  const bool staggered = board.kind == capture::BoardKind::asymmetric_circles;
  const double radius = dot_radius * (staggered ? std::numbers::sqrt2 : 1.0);
  const int j = std::clamp(static_cast<int>(std::lround(position.y())), 0, board.rows - 1);
  double ink = 0.0;
  for (int row = std::max(0, j - 1); row <= std::min(board.rows - 1, j + 1); ++row) {
    const double shift = staggered ? row % 2 : 0.0;
    const double step = staggered ? 2.0 : 1.0;
    const int i = std::clamp(static_cast<int>(std::lround((position.x() - shift) / step)), 0,
                             board.columns - 1);
    const Vector2d offset = position - Vector2d(shift + step * i, row);
    const double distance = offset.norm();
    const Vector2d outward = distance > 0.0 ? Vector2d(offset / distance) : Vector2d::UnitX();
    const double blur = outward.cwiseProduct(width).norm();
    ink += coverage(distance, -radius, radius, blur);
  }
  return ink;
}

/// The same of the markers alone; they are numbered row by row over the light squares.
double marker_ink(const Vector2d& position, const capture::Board& board,
                  const std::vector<calib::MarkerCells>& markers, const Vector2d& width) {
  // Squares are numbered from the board's dark corner square, whose outer corner is (-1, -1).
  const int column = static_cast<int>(std::floor(position.x())) + 1;
  const int row = static_cast<int>(std::floor(position.y())) + 1;
  if (column < 0 || row < 0 || column > board.columns || row > board.rows) return 0.0;
  if ((column + row) % 2 == 0) return 0.0;
  const int squares = board.columns + 1;
  const int id = row * squares / 2 + column / 2;
  const double side = board.marker_mm / board.square_mm;
  const Vector2d first = Vector2d(column - 1, row - 1) + Vector2d::Constant(0.5 * (1.0 - side));
  const calib::MarkerCells& marker = markers[static_cast<std::size_t>(id)];
  const double cell = side / marker.side;
  double ink = 0.0;
  for (int v = 0; v < marker.side; ++v) {
    const double across =
        coverage(position.y(), first.y() + v * cell, first.y() + (v + 1) * cell, width.y());
    if (across <= 0.0) continue;
    for (int u = 0; u < marker.side; ++u) {
      if (marker.light[static_cast<std::size_t>(v) * marker.side + u] != 0) continue;
      ink += across *
             coverage(position.x(), first.x() + u * cell, first.x() + (u + 1) * cell, width.x());
    }
  }
  return ink;
}

std::vector<calib::MarkerCells> markers_of(const capture::Board& board) {
  std::vector<calib::MarkerCells> markers;
  if (board.kind != capture::BoardKind::charuco) return markers;
  const int count = (board.columns + 1) * (board.rows + 1) / 2;
  for (int id = 0; id < count; ++id) {
    markers.push_back(calib::marker_cells(board.dictionary, id));
  }
  return markers;
}

constexpr double chart_gap = 0.16;     // between patches, in pitches
constexpr double chart_border = 0.25;  // dark frame beyond the outer pitches, in pitches
constexpr double chart_frame_reflectance = 0.035;

}  // namespace

Quad board_quad(const capture::Board& board, const Rigid& world_from_board) {
  const double margin = (1.0 + board_margin_squares) * board.square_mm;
  const bool staggered = board.kind == capture::BoardKind::asymmetric_circles;
  const int last_column = staggered ? 2 * board.columns - 1 : board.columns - 1;
  Quad quad;
  quad.world_from_quad = world_from_board;
  quad.low = Vector2d::Constant(-margin);
  quad.high =
      Vector2d(last_column * board.square_mm + margin, (board.rows - 1) * board.square_mm + margin);
  const std::vector<calib::MarkerCells> markers = markers_of(board);
  quad.albedo = [board, markers](const Vector2d& position, const Vector2d& footprint) {
    const Vector2d at = position / board.square_mm;
    const Vector2d width = footprint / board.square_mm;
    double ink = 0.0;
    if (board.kind == capture::BoardKind::circles ||
        board.kind == capture::BoardKind::asymmetric_circles) {
      ink = dot_ink(at, board, width);
    } else {
      ink = chessboard_ink(at, board.columns, board.rows, width);
      if (!markers.empty()) ink += marker_ink(at, board, markers, width);
    }
    const double value = paper_reflectance + ink * (ink_reflectance - paper_reflectance);
    return std::array<double, 3>{value, value, value};
  };
  return quad;
}

Quad plain_quad(const Vector2d& size_mm, double reflectance, const Rigid& world_from_quad) {
  Quad quad;
  quad.world_from_quad = world_from_quad;
  quad.low = -0.5 * size_mm;
  quad.high = 0.5 * size_mm;
  quad.albedo = [reflectance](const Vector2d&, const Vector2d&) {
    return std::array<double, 3>{reflectance, reflectance, reflectance};
  };
  return quad;
}

double chart_height_mm(double width_mm) {
  return width_mm * (4.0 + 2.0 * chart_border) / (6.0 + 2.0 * chart_border);
}

const std::array<std::array<double, 3>, 24>& chart_reflectances() {
  static const std::array<std::array<double, 3>, 24> reflectances = [] {
    constexpr std::array<std::array<double, 3>, 24> lab{{
        {37.54, 14.37, 14.92},  {64.66, 19.27, 17.50},  {49.32, -3.82, -22.54},
        {43.46, -12.74, 22.72}, {54.94, 9.61, -24.79},  {70.48, -32.26, -0.37},
        {62.73, 35.83, 56.50},  {39.43, 10.75, -45.17}, {50.57, 48.64, 16.67},
        {30.10, 22.54, -20.87}, {71.77, -24.13, 58.19}, {71.51, 18.24, 67.37},
        {28.37, 15.42, -49.80}, {54.38, -39.72, 32.27}, {42.43, 51.05, 28.62},
        {81.80, 2.67, 80.41},   {50.63, 51.28, -14.12}, {49.57, -29.71, -28.32},
        {95.19, -1.03, 2.93},   {81.29, -0.57, 0.44},   {66.89, -0.75, -0.06},
        {50.76, -0.13, 0.14},   {35.63, -0.46, -0.48},  {20.64, 0.07, -0.46},
    }};
    const auto inverse_f = [](double t) {  // CIE 15:2004, inverse of the L*a*b* function
      return t > 6.0 / 29.0 ? t * t * t : 3.0 * 36.0 / 841.0 * (t - 4.0 / 29.0);
    };
    // XYZ (D50) to linear sRGB, Bradford adaptation (B. Lindbloom).
    const Eigen::Matrix3d rgb_from_xyz{{3.1338561, -1.6168667, -0.4906146},
                                       {-0.9787684, 1.9161415, 0.0334540},
                                       {0.0719453, -0.2289914, 1.4052427}};
    std::array<std::array<double, 3>, 24> out{};
    for (std::size_t p = 0; p < lab.size(); ++p) {
      const double f = (lab[p][0] + 16.0) / 116.0;
      const Vector3d xyz(0.9642 * inverse_f(f + lab[p][1] / 500.0), inverse_f(f),
                         0.8251 * inverse_f(f - lab[p][2] / 200.0));
      const Vector3d rgb = p < 18 ? Vector3d(rgb_from_xyz * xyz) : Vector3d::Constant(xyz.y());
      for (int c = 0; c < 3; ++c) out[p][c] = std::clamp(rgb[c], 0.005, 1.0);
    }
    return out;
  }();
  return reflectances;
}

Quad chart_quad(double width_mm, const Rigid& world_from_chart) {
  const double pitch = width_mm / (6.0 + 2.0 * chart_border);
  Quad quad = plain_quad({width_mm, chart_height_mm(width_mm)}, 0.0, world_from_chart);
  const Vector2d first = quad.low + Vector2d::Constant(chart_border * pitch);
  quad.albedo = [=](const Vector2d& position, const Vector2d& footprint) {
    const Vector2d at = (position - first) / pitch;
    const int column = std::clamp(static_cast<int>(std::floor(at.x())), 0, 5);
    const int row = std::clamp(static_cast<int>(std::floor(at.y())), 0, 3);
    const Vector2d width = footprint / pitch;
    const double on_patch =
        coverage(at.x(), column + 0.5 * chart_gap, column + 1.0 - 0.5 * chart_gap, width.x()) *
        coverage(at.y(), row + 0.5 * chart_gap, row + 1.0 - 0.5 * chart_gap, width.y());
    std::array<double, 3> albedo{};
    for (int c = 0; c < 3; ++c) {
      albedo[c] = chart_frame_reflectance +
                  on_patch * (chart_reflectances()[row * 6 + column][c] - chart_frame_reflectance);
    }
    return albedo;
  };
  return quad;
}

}  // namespace kappamu::synthetic
