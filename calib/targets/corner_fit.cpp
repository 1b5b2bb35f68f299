#include "calib/targets/corner_fit.h"

#include <ceres/tiny_solver.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "calib/targets/board_picture.h"

namespace kappamu::calib {
namespace {

struct Pixel {
  Eigen::Vector2d at;  ///< from the start
  double value;        ///< in units of half the contrast
};

/// The sign of a distance, blurred by a Gaussian and averaged over a box, and its derivatives.
struct Step {
  double value = 0.0;
  double by_distance = 0.0;
  double by_blur = 0.0;  ///< by the deviation
};
Step blurred_step(double distance, double deviation, double box) {
  const double from = (distance - 0.5 * box) / deviation;
  const double to = (distance + 0.5 * box) / deviation;
  constexpr double far = 6.0;  // the tail beyond is below 1e-8
  if (from > far) return {1.0, 0.0, 0.0};
  if (to < -far) return {-1.0, 0.0, 0.0};
  const auto sign = [](double t) { return std::erf(t / std::numbers::sqrt2); };
  const auto density = [](double t) {
    return std::sqrt(2.0 / std::numbers::pi) * std::exp(-0.5 * t * t);
  };
  const double rise = density(to) - density(from);
  // The integral of the blurred sign is t erf(t/√2) + √(2/π) exp(-t²/2), t in deviations.
  return {deviation / box * (to * sign(to) - from * sign(from) + rise),
          (sign(to) - sign(from)) / box, rise / box};
}

/// Distance of pixels from a straight edge through the corner, as a blurred sign. A pixel's extent
/// across an edge of normal n is that of two boxes, |n_x| and |n_y| wide: the wider one is kept,
/// the other adds its variance to the Gaussian's.
class Edge {
 public:
  Edge(double angle, double blur) : normal_(std::cos(angle), std::sin(angle)) {
    const Eigen::Vector2d extent = normal_.cwiseAbs();
    box_ = extent.maxCoeff();
    deviation_ = std::sqrt(blur * blur + extent.minCoeff() * extent.minCoeff() / 12.0);
    by_log_blur_ = blur * blur / deviation_;
  }

  const Eigen::Vector2d& normal() const { return normal_; }
  /// By the angle: a turn moves the edge along itself by the distance from the corner.
  double lever(const Eigen::Vector2d& at) const {
    return normal_.x() * at.y() - normal_.y() * at.x();
  }
  Step at(const Eigen::Vector2d& at) const {
    Step step = blurred_step(normal_.dot(at), deviation_, box_);
    step.by_blur *= by_log_blur_;
    return step;
  }

 private:
  Eigen::Vector2d normal_;
  double box_ = 1.0;
  double deviation_ = 1.0;
  double by_log_blur_ = 1.0;
};

/// The model of corner_fit.h as ceres::TinySolver wants it.
class Saddle {
 public:
  enum Number {
    corner_x,
    corner_y,
    angle_1,
    angle_2,
    log_blur,  ///< of the Gaussian's deviation [px]
    mean,
    contrast,
    bow,
    shade_x,
    shade_y
  };
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = shade_y + 1 };

  static constexpr double usual_blur_px = 0.5;

  explicit Saddle(const std::vector<Pixel>& pixels) : pixels_(pixels) {}
  /// The last one holds the blur, which a picture without any would send to minus infinity.
  int NumResiduals() const { return static_cast<int>(pixels_.size()) + 1; }

  bool operator()(const double* p, double* residuals, double* jacobian) const {
    const Edge first(p[angle_1], std::exp(p[log_blur]));
    const Edge second(p[angle_2], std::exp(p[log_blur]));
    const Eigen::Vector2d slope(p[shade_x], p[shade_y]);
    const auto rows = static_cast<Eigen::Index>(pixels_.size());
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, NUM_PARAMETERS>> derivative(
        jacobian, jacobian == nullptr ? 0 : rows + 1, NUM_PARAMETERS);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const Pixel& pixel = pixels_[static_cast<std::size_t>(k)];
      const Eigen::Vector2d at(pixel.at.x() - p[corner_x], pixel.at.y() - p[corner_y]);
      const Step one = first.at(at);
      const Step two = second.at(at);
      const double product = one.value * two.value;
      const double light = 1.0 + slope.dot(at);
      const double level = p[mean] + (p[contrast] + p[bow] * product) * product;
      residuals[k] = light * level - pixel.value;
      if (jacobian == nullptr) continue;
      const double by_product = light * (p[contrast] + 2.0 * p[bow] * product);
      const double by_first = by_product * one.by_distance * two.value;
      const double by_second = by_product * one.value * two.by_distance;
      const Eigen::Vector2d by_corner =
          -by_first * first.normal() - by_second * second.normal() - level * slope;
      derivative.row(k) << by_corner.x(), by_corner.y(), by_first * first.lever(at),
          by_second * second.lever(at),
          by_product * (one.by_blur * two.value + one.value * two.by_blur), light, light * product,
          light * product * product, level * at.x(), level * at.y();
    }
    constexpr double hold = 0.05;  // of half the contrast: far below what blur changes
    residuals[rows] = hold * (p[log_blur] - std::log(usual_blur_px));
    if (jacobian != nullptr) {
      derivative.row(rows).setZero();
      derivative(rows, log_blur) = hold;
    }
    return true;
  }

 private:
  const std::vector<Pixel>& pixels_;
};
using Numbers = Eigen::Matrix<double, Saddle::NUM_PARAMETERS, 1>;

constexpr double longest_steps = 0.8;  // the next corner's blur ends before

std::vector<Pixel> pixels_about(const Image<float>& grey, const Eigen::Vector2d& start,
                                const CornerWindow& window) {
  const Eigen::Matrix2d in_steps = window.steps.inverse();
  const double along_row = std::min(longest_steps, window.longest_px / window.steps.col(0).norm());
  const double along_column =
      std::min(longest_steps, window.longest_px / window.steps.col(1).norm());
  const Eigen::Vector2d reach = window.steps.cwiseAbs() * Eigen::Vector2d(along_row, along_column);
  std::vector<Pixel> pixels;
  const auto from = [](double low) { return std::max(0, static_cast<int>(std::ceil(low))); };
  const auto to = [](double high, int size) {
    return std::min(size - 1, static_cast<int>(std::floor(high)));
  };
  for (int y = from(start.y() - reach.y()); y <= to(start.y() + reach.y(), grey.height()); ++y) {
    for (int x = from(start.x() - reach.x()); x <= to(start.x() + reach.x(), grey.width()); ++x) {
      const Eigen::Vector2d at = Eigen::Vector2d(x, y) - start;
      const Eigen::Vector2d steps = (in_steps * at).cwiseAbs();
      if (steps.x() > along_row || steps.y() > along_column || steps.minCoeff() > window.clear) {
        continue;
      }
      pixels.push_back({at, grey(x, y)});
    }
  }
  return pixels;
}

/// Steps along rows and columns at every corner: the derivatives of the board's perspective view.
std::vector<Eigen::Matrix2d> steps_at(const BoardCorners& corners) {
  std::vector<cv::Point2d> places;
  std::vector<cv::Point2d> pixels;
  for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
    const auto [i, j] = corners.place(k);
    places.emplace_back(i, j);
    pixels.emplace_back(corners.pixels[k].x(), corners.pixels[k].y());
  }
  const cv::Mat found = cv::findHomography(places, pixels);
  if (found.empty()) return {};
  const Eigen::Matrix3d view =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(found.ptr<double>());
  std::vector<Eigen::Matrix2d> steps;
  for (const cv::Point2d& place : places) {
    const Eigen::Vector3d seen = view * Eigen::Vector3d(place.x, place.y, 1.0);
    steps.emplace_back(
        (view.topLeftCorner<2, 2>() - seen.head<2>() / seen.z() * view.bottomLeftCorner<1, 2>()) /
        seen.z());
  }
  return steps;
}

/// Where the gradients about `start` meet, in a window of `half` pixels to each side. The picture
/// is smoothed there alone.
Eigen::Vector2d by_gradients(const Image<float>& grey, const Eigen::Vector2d& start, int half) {
  const double deviation = std::min(1.5, half / 3.0);
  // OpenCV takes a start back where it leaves its window, and its Gaussian ends at four deviations.
  const int reach = 2 * half + 2 + static_cast<int>(std::ceil(4.0 * deviation));
  const int x = static_cast<int>(std::lround(start.x())),
            y = static_cast<int>(std::lround(start.y()));
  const cv::Rect around = cv::Rect(x - reach, y - reach, 2 * reach + 1, 2 * reach + 1) &
                          cv::Rect(0, 0, grey.width(), grey.height());
  if (around.width <= 2 * half + 5 || around.height <= 2 * half + 5) return start;
  cv::Mat smooth;
  cv::GaussianBlur(view_of(grey)(around), smooth, cv::Size(), deviation);
  const cv::TermCriteria stop(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-4);
  std::vector<cv::Point2f> point{cv::Point2f(static_cast<float>(start.x() - around.x),
                                             static_cast<float>(start.y() - around.y))};
  cv::cornerSubPix(smooth, point, cv::Size(half, half), cv::Size(-1, -1), stop);
  return {point[0].x + around.x, point[0].y + around.y};
}

}  // namespace

std::optional<Eigen::Vector2d> fit_corner(const Image<float>& grey, const Eigen::Vector2d& start,
                                          const CornerWindow& window) {
  std::vector<Pixel> pixels = pixels_about(grey, start, window);
  constexpr std::size_t fewest = 3 * Saddle::NUM_PARAMETERS;
  if (pixels.size() < fewest) return std::nullopt;
  // The squares' levels, from which side of both edges a pixel lies; edge 1 runs along the row.
  Numbers numbers = Numbers::Zero();
  numbers[Saddle::angle_1] = std::atan2(window.steps(0, 0), -window.steps(1, 0));
  numbers[Saddle::angle_2] = std::atan2(window.steps(0, 1), -window.steps(1, 1));
  numbers[Saddle::log_blur] = std::log(Saddle::usual_blur_px);
  const Edge first(numbers[Saddle::angle_1], 0.0);
  const Edge second(numbers[Saddle::angle_2], 0.0);
  std::array<double, 2> sum{};
  std::array<int, 2> count{};
  for (const Pixel& pixel : pixels) {
    const std::size_t side =
        first.normal().dot(pixel.at) * second.normal().dot(pixel.at) > 0.0 ? 1 : 0;
    sum[side] += pixel.value;
    ++count[side];
  }
  if (count[0] == 0 || count[1] == 0) return std::nullopt;
  const double low = sum[0] / count[0];
  const double high = sum[1] / count[1];
  const double unit = 0.5 * std::abs(high - low);
  if (unit == 0.0) return std::nullopt;
  for (Pixel& pixel : pixels) pixel.value /= unit;
  numbers[Saddle::mean] = 0.5 * (low + high) / unit;
  numbers[Saddle::contrast] = high > low ? 1.0 : -1.0;
  const Saddle saddle(pixels);
  ceres::TinySolver<Saddle> solver;
  solver.options.parameter_tolerance = 1e-5;
  solver.options.function_tolerance = 1e-8;
  const auto& summary = solver.Solve(saddle, &numbers);
  constexpr double furthest_px = 2.0;
  constexpr double worst_residual = 0.25;  // of half the contrast, root mean square
  const double residual = std::sqrt(2.0 * summary.final_cost / static_cast<double>(pixels.size()));
  const Eigen::Vector2d shift = numbers.head<2>();
  // Also false for what is not a number.
  const bool is_corner =
      residual < worst_residual * std::abs(numbers[Saddle::contrast]) && shift.norm() < furthest_px;
  // In sharpened pictures the blur runs to nothing and never settles; the corner has.
  if (!is_corner) return std::nullopt;
  return start + shift;
}

void refine_corners(const Image<float>& grey, BoardCorners& corners, double clear) {
  const double part = std::min(clear, 0.4);  // the window never sees a neighbouring corner
  const int half = std::clamp(static_cast<int>(part * smallest_spacing(corners)), 2,
                              static_cast<int>(CornerWindow{}.longest_px));
  const std::vector<Eigen::Vector2d> detected = corners.pixels;
  for (Eigen::Vector2d& pixel : corners.pixels) pixel = by_gradients(grey, pixel, half);
  const std::vector<Eigen::Matrix2d> steps = steps_at(corners);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    CornerWindow window{steps[k], clear};
    auto fitted = fit_corner(grey, corners.pixels[k], window);
    // Something else lies in the windows, as the outer edge of a narrow border square: again from
    // where it was found, in a smaller one.
    if (!fitted) {
      window.longest_px *= 0.5;
      fitted = fit_corner(grey, detected[k], window);
    }
    if (fitted) corners.pixels[k] = *fitted;
  }
}

void refine_corners_from(double factor, const Image<float>& grey, BoardCorners& corners,
                         double clear) {
  if (factor < 1.0) {
    const ScaledPicture picture(view_of(grey), factor);
    for (Eigen::Vector2d& pixel : corners.pixels) pixel = picture.in_scaled(pixel);
    refine_corners(image_of(picture.pixels), corners, clear);
    for (const cv::Point2f& point : image_points(std::exchange(corners.pixels, {}))) {
      corners.pixels.push_back(picture.in_original(point));
    }
  }
  refine_corners(grey, corners, clear);
}

}  // namespace kappamu::calib
