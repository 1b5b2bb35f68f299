#include "calib/projector/view_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "core/numbers/median.h"
#include "core/shown_text.h"

namespace kappamu::calib {
namespace {

double angle_degrees(const Rigid& a, const Rigid& b) {
  const double cosine = std::abs(a.rotation.col(2).dot(b.rotation.col(2)));
  return std::acos(std::min(1.0, cosine)) * 180.0 / std::numbers::pi;
}

/// The view whose normal lies closest to all others: the one to take again first.
std::size_t most_parallel(const std::vector<Rigid>& poses) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < poses.size(); ++v) {
    double sum = 0.0;
    for (const Rigid& other : poses) sum += angle_degrees(poses[v], other);
    if (sum < least) {
      least = sum;
      best = v;
    }
  }
  return best;
}

Eigen::Vector2d middle_of(const BoardView& view) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& pixel : view.corners.pixels) sum += pixel;
  return sum / static_cast<double>(view.corners.pixels.size());
}

/// The view in the thick of the others: the one least missed where it is.
std::size_t most_central(const std::vector<BoardView>& views) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const BoardView& view : views) mean += middle_of(view);
  mean /= static_cast<double>(views.size());
  const auto found =
      std::min_element(views.begin(), views.end(), [&mean](const BoardView& a, const BoardView& b) {
        return (middle_of(a) - mean).norm() < (middle_of(b) - mean).norm();
      });
  return static_cast<std::size_t>(found - views.begin());
}

void check_tilt(const std::vector<BoardView>& views, const CameraCalibration& camera,
                std::vector<std::string>& sentences) {
  constexpr double useless = 0.05;
  constexpr double uncertain = 0.02;
  const double deviation = camera.standard_deviation(0) / camera.lens.fx;
  // The negation also takes what is not a number.
  if (deviation <= uncertain) return;
  const std::string known =
      "the focal length is known to " + shown_number(100.0 * deviation, "%.1f") + " % only";
  const double tilt = largest_tilt_degrees(camera.camera_from_board);
  const std::string& view = views[most_parallel(camera.camera_from_board)].name;
  const std::string cause =
      "camera calibration: the boards of all " + std::to_string(views.size()) +
      " views lie within " + shown_number(tilt, "%.1f") + " degrees of parallel and " + known +
      "; photograph the board tilted by 20 to 40 degrees in different directions, " + view +
      " first";
  if (!(deviation <= useless)) throw InputError(cause);
  sentences.push_back(cause + ".");
}

void check_coverage(const std::vector<BoardView>& views, const CameraCalibration& camera,
                    std::vector<std::string>& sentences) {
  constexpr double unseen = 0.25;  // of the picture's width or height
  double left = 1.0;
  double right = 0.0;
  double top = 1.0;
  double bottom = 0.0;
  for (const BoardView& view : views) {
    for (const Eigen::Vector2d& pixel : view.corners.pixels) {
      left = std::min(left, pixel.x() / camera.lens.width);
      right = std::max(right, pixel.x() / camera.lens.width);
      top = std::min(top, pixel.y() / camera.lens.height);
      bottom = std::max(bottom, pixel.y() / camera.lens.height);
    }
  }
  std::string sides;
  const auto side = [&sides](const char* name, double part) {
    if (part <= unseen) return;
    sides += (sides.empty() ? "the " : ", the ") + std::string(name) + " " +
             shown_number(100.0 * part, "%.0f") + " %";
  };
  side("left", left);
  side("right", 1.0 - right);
  side("top", top);
  side("bottom", 1.0 - bottom);
  if (sides.empty()) return;
  sentences.push_back("no board view reaches " + sides +
                      " of the picture, where the lens' distortion is a guess: move the board "
                      "there, " +
                      views[most_central(views)].name + " first.");
}

void check_blur(const std::vector<BoardView>& views, std::vector<std::string>& sentences) {
  std::vector<double> widths;
  for (const BoardView& view : views) {
    if (view.corners.blur_px > 0.0) widths.push_back(view.corners.blur_px);
  }
  if (widths.empty()) return;
  const double middle = upper_median(std::move(widths));
  constexpr double harmless_px = 1.5;
  constexpr double times_the_others = 1.8;
  for (const BoardView& view : views) {
    const double blur = view.corners.blur_px;
    const bool against_others = blur > times_the_others * middle;
    if (blur < harmless_px || (!against_others && middle < 2.0 * harmless_px)) continue;
    sentences.push_back(view.name + ": the board's edges are blurred over " +
                        shown_number(blur, "%.1f") + " px (standard deviation; " +
                        shown_number(middle, "%.1f") +
                        " px in the middle view): take it again, in focus and with the board at "
                        "rest.");
  }
}

void check_outliers(const CameraCalibration& camera, std::vector<std::string>& sentences) {
  std::vector<double> errors;
  for (const ViewResidual& view : camera.views) errors.push_back(view.rms_px);
  const double middle = upper_median(std::move(errors));
  for (const ViewResidual& view : camera.views) {
    if (!view.left_out.empty()) {
      const std::size_t found = view.pixels.size(), many = found / 10;
      sentences.push_back(view.name + ": " + std::to_string(view.left_out.size()) + " of " +
                          std::to_string(found) +
                          " corners lie further than six standard deviations from where the other "
                          "views put them and were left out; " +
                          (view.left_out.size() > many
                               ? "take it again."
                               : "up to " + std::to_string(many) + ", a tenth, do no harm."));
    }
    constexpr double times_the_others = 3.0;
    constexpr double smallest_px = 0.3;
    if (view.rms_px > std::max(smallest_px, times_the_others * middle)) {
      sentences.push_back(view.name + ": its corners fit " + shown_number(view.rms_px, "%.2f") +
                          " px badly where the middle view has " + shown_number(middle, "%.2f") +
                          " px: a bent or moving board, or one of another size; take it again or "
                          "take it out of session.json.");
    }
  }
}

}  // namespace

double largest_tilt_degrees(const std::vector<Rigid>& camera_from_board) {
  double largest = 0.0;
  for (std::size_t a = 0; a < camera_from_board.size(); ++a) {
    for (std::size_t b = a + 1; b < camera_from_board.size(); ++b) {
      largest = std::max(largest, angle_degrees(camera_from_board[a], camera_from_board[b]));
    }
  }
  return largest;
}

std::vector<std::string> check_camera_views(const std::vector<BoardView>& views,
                                            const CameraCalibration& camera) {
  std::vector<std::string> sentences;
  check_tilt(views, camera, sentences);
  check_coverage(views, camera, sentences);
  check_blur(views, sentences);
  check_outliers(camera, sentences);
  return sentences;
}

std::vector<std::string> check_planes(const std::vector<PlaneView>& planes) {
  std::vector<std::string> sentences;
  int dark = 0;
  int light = 0;
  for (const PlaneView& plane : planes) {
    if (!plane.projected.first_square_dark) continue;
    ++(*plane.projected.first_square_dark ? dark : light);
  }
  if (dark == 0 || light == 0) return sentences;
  const bool usual = dark >= light;
  for (const PlaneView& plane : planes) {
    const auto& first = plane.projected.first_square_dark;
    if (!first || *first == usual) continue;
    sentences.push_back(plane.name +
                        ": the projected board is turned by 180 degrees against the other planes "
                        "(its first square is " +
                        (*first ? "dark" : "light") +
                        "): turn the camera's picture upright, or take the plane out of "
                        "session.json.");
  }
  return sentences;
}

std::vector<std::string> check_scale(const std::vector<Rigid>& station_from_plane,
                                     const Rigid& camera_from_sample, double square_mm) {
  std::vector<double> distances;
  for (const Rigid& plane : station_from_plane) distances.push_back(plane.translation.norm());
  const double middle = upper_median(std::move(distances));
  const double sample = camera_from_sample.translation.norm();
  constexpr double suspicious = 1.25;
  const double ratio = middle / sample;
  if (ratio < suspicious && ratio > 1.0 / suspicious) return {};
  return {"the projector's planes stand " + shown_number(middle, "%.0f") +
          " mm from the camera and the sample " + shown_number(sample, "%.0f") +
          " mm: check calibration.board.square_mm (" + shown_number(square_mm, "%.3g") +
          ") and sample.voxel_mm in session.json, and put the planes where the sample stands."};
}

}  // namespace kappamu::calib
