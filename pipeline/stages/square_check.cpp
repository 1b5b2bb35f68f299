#include "pipeline/stages/square_check.h"

#include <cmath>
#include <numbers>

#include "calib/sample/face.h"
#include "core/shown_text.h"

namespace kappamu::pipeline {

namespace {

constexpr double least_turn = 5.0;        // of a camera that looks aslant [degrees]
constexpr double least_along = 0.8;       // cosine between the shift and the camera's side
constexpr double limit_deviations = 3.0;  // a shift's limit is as many of its deviations

std::string percent(double share) {
  return shown_number(100.0 * share, "%.1f");
}

std::string warning_of(const SquareSize& size) {
  const double factor = std::exp(size.log_factor.value);
  return "Such a shift comes about where the printed squares are about " +
         percent(std::abs(factor - 1.0)) + " % (standard deviation " +
         percent(size.log_factor.error) + " %) " + (factor > 1.0 ? "larger" : "smaller") +
         " than calibration.board.square_mm in session.json says, or the block as much " +
         (factor > 1.0 ? "smaller" : "larger") +
         " than sample.grid and sample.voxel_mm say: measure the board over many squares, and the "
         "block, correct session.json and calibrate again.";
}

/// Where the camera looks from beside the normal and the images lie towards it.
std::optional<std::string> aslant(const inverse::Consistency& consistency,
                                  const SurfaceMeasurements& m) {
  const auto camera = m.cameras.find(m.seen_face);
  if (camera == m.cameras.end()) return std::nullopt;
  const auto [u, v] = face_axes(m.seen_face);
  const int n = axis_of(m.seen_face);
  const auto extent = [&](int axis) { return m.grid.extent(axis) * m.grid.voxel_mm; };
  const Eigen::Vector2d beside(camera->second[u] - 0.5 * extent(u),
                               camera->second[v] - 0.5 * extent(v));
  const double above = is_plus(m.seen_face) ? camera->second[n] - extent(n) : -camera->second[n];
  const double turn = std::atan2(beside.norm(), above) * 180.0 / std::numbers::pi;
  const Eigen::Vector2d shift(consistency.shift_u.value, consistency.shift_v.value);
  if (turn < least_turn || shift.dot(beside) < least_along * shift.norm() * beside.norm()) {
    return std::nullopt;
  }
  return formatted(
      "The camera looks from %.0f degrees beside the normal, and light that leaves aslant was "
      "scattered last that far aside of where it is seen: diffusion knows nothing of it. Fit with "
      "the physics transport, which follows it to the camera, or photograph along the normal.",
      turn);
}

std::string in_words(const SquareSize& size) {
  return "Light and images put the printed squares at " + percent(std::exp(size.log_factor.value)) +
         " % of calibration.board.square_mm; an error is "
         "reported beyond " +
         percent(size.limit) + " %.";
}

}  // namespace

// The stated pixel of a point X lies along P = R X + t0 from the projector, R and t0 being
// projector_from_sample. Squares s times as large put the projector's origin at s t instead of t in
// the camera's frame, so that this beam meets the face's plane (normal n) at X' = X + dX with
// R dX + ds t = dl P and n dX = 0.
Eigen::Vector3d light_shift_per_log_square(const calib::CalibrationResult& calibration,
                                           const GridShape& grid, Face lit_face) {
  const auto corners = calib::face_corners(grid, lit_face);
  const Rigid& projector = calibration.projector_from_sample;
  const Eigen::Matrix3d sample_from_projector = projector.rotation.transpose();
  const Eigen::Vector3d beam =
      sample_from_projector * (projector * (0.5 * (corners[0] + corners[2])));
  const Eigen::Vector3d base =
      sample_from_projector * calibration.projector.projector_from_station.translation;
  const Eigen::Vector3d normal = calib::face_normal(lit_face);
  return beam * (normal.dot(base) / normal.dot(beam)) - base;
}

std::optional<SquareSize> check_square_size(const inverse::Consistency& consistency,
                                            const calib::CalibrationResult& calibration,
                                            const SurfaceMeasurements& measurements) {
  if (!consistency.checked) return std::nullopt;
  const GridShape& grid = measurements.grid;
  const Eigen::Vector3d moved =
      light_shift_per_log_square(calibration, grid, measurements.lit_face) / grid.voxel_mm;
  // The seen face's axes, per voxel.
  const auto axis = [&](double u, double v) -> Eigen::Vector3d {
    return (calib::face_point(grid, measurements.seen_face, u, v) -
            calib::face_point(grid, measurements.seen_face, 0.0, 0.0)) /
           grid.voxel_mm;
  };
  const Eigen::Vector2d line(moved.dot(axis(1.0, 0.0)), moved.dot(axis(0.0, 1.0)));
  const Eigen::Vector2d shift(consistency.shift_u.value, consistency.shift_v.value);
  SquareSize size;
  size.log_factor.value = shift.dot(line) / line.squaredNorm();
  size.limit = consistency.shift_limit / line.norm();
  size.log_factor.error = size.limit / limit_deviations;
  const double across = (shift - size.log_factor.value * line).norm();
  size.explains = consistency.is_shifted() && across < consistency.shift_limit;
  return size;
}

std::vector<ShiftFindings> check_shift(std::span<const inverse::Consistency> channels,
                                       const std::optional<calib::CalibrationResult>& calibration,
                                       const SurfaceMeasurements& measurements) {
  std::vector<ShiftFindings> findings(channels.size());
  const std::optional<std::size_t> shifted = inverse::shifted_channel(channels);
  if (shifted) {
    findings[*shifted].warnings.push_back(
        inverse::shift_sentence(channels[*shifted], measurements.grid, measurements.seen_face));
    if (const auto sentence = aslant(channels[*shifted], measurements)) {
      findings[*shifted].warnings.push_back(*sentence);
    }
  }
  for (std::size_t c = 0; c < channels.size() && calibration; ++c) {
    const std::optional<SquareSize> size =
        check_square_size(channels[c], *calibration, measurements);
    if (!size) continue;
    const bool is_aslant = c == shifted && aslant(channels[c], measurements);
    if (c == shifted && size->explains && !is_aslant) {
      findings[c].warnings.push_back(warning_of(*size));
    } else {
      findings[c].notes.push_back(in_words(*size));
    }
  }
  return findings;
}

}  // namespace kappamu::pipeline
