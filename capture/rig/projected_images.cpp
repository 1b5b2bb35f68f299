// The images a plan shows: bars, patches, chessboard, uniform grey. Declared in shoot.h.
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "capture/rig/shoot.h"
#include "core/error.h"

namespace kappamu::capture {
namespace {

// Homography that maps the unit square's corners (0,0), (1,0), (1,1), (0,1) to the quad's (Heckbert
// 1989, section 2.2.3).
Eigen::Matrix3d quad_from_square(const ProjectorQuad& quad) {
  std::array<Eigen::Vector2d, 4> corner;
  for (std::size_t i = 0; i < 4; ++i) corner[i] = {quad[i][0], quad[i][1]};
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d to_next = corner[(i + 1) % 4] - corner[i];
    const Eigen::Vector2d to_last = corner[(i + 3) % 4] - corner[i];
    constexpr double straight = 1e-12;
    if (!(std::abs(cross(to_next, to_last)) > straight * to_next.norm() * to_last.norm())) {
      throw InputError(
          "the quad of the light patterns has corners in one line or coinciding; give the four "
          "corners of the lit face in projector pixels.");
    }
  }
  const Eigen::Vector2d right = corner[1] - corner[2], left = corner[3] - corner[2];
  const Eigen::Vector2d skew = corner[0] - corner[1] + corner[2] - corner[3];
  const double area = cross(right, left);
  const double g = cross(skew, left) / area, h = cross(right, skew) / area;
  Eigen::Matrix3d homography;
  homography.col(0) << corner[1] - corner[0] + g * corner[1], g;
  homography.col(1) << corner[3] - corner[0] + h * corner[3], h;
  homography.col(2) << corner[0], 1.0;
  return homography;
}

// Mean over [at - 1/2, at + 1/2] of the square wave that is +1 on [0, 1), -1 on [1, 2), ... in
// units of the square; `at` and the returned mean in pixels of `square_px`.
double mean_wave(double at, double origin, double square_px) {
  // The wave's integral is a triangle wave.
  const auto integral = [](double x) {
    const double phase = x - 2.0 * std::floor(0.5 * x);
    return phase < 1.0 ? phase : 2.0 - phase;
  };
  const double low = (at - 0.5 - origin) / square_px;
  const double high = (at + 0.5 - origin) / square_px;
  return (integral(high) - integral(low)) * square_px;
}

// Share of the pixel at `at` that lies in [low, high].
double coverage(double at, double low, double high) {
  return std::clamp(std::min(at + 0.5, high) - std::max(at - 0.5, low), 0.0, 1.0);
}

std::uint8_t grey(double share) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
}

void must_be_count(int n, const std::string& of) {
  if (n >= 1 && n <= 1000) return;
  throw InputError("the number of " + of + " is " + std::to_string(n) +
                   "; it must lie between 1 and 1000.");
}

/// How the quad is divided and what becomes of its cells.
struct Division {
  int n;  ///< cells along an edge
  double overhang;
  int patterns;
  PatternRole role;
  std::string prefix;
};

/// Patterns of white cells on black: `patterns_of`(column, row) names those that light a cell.
template <typename PatternsOf>
std::vector<PlannedPattern> lit_cells(const Projector& projector, const ProjectorQuad& quad,
                                      const Division& division, const PatternsOf& patterns_of) {
  const double overhang = division.overhang;
  if (!(overhang >= 0.0 && overhang <= 1.0)) {
    throw InputError("the overhang of the outer patches must lie between 0 and 1 face widths.");
  }
  const auto cell_of = [n = division.n](double t) {
    return std::clamp(static_cast<int>(std::floor(t * n)), 0, n - 1);
  };
  const auto inside = [overhang](double t) { return t >= -overhang && t < 1.0 + overhang; };
  const Eigen::Matrix3d square_from_quad = quad_from_square(quad).inverse();
  std::vector<PlannedPattern> patterns;
  const std::size_t digits = std::max<std::size_t>(2, std::to_string(division.patterns - 1).size());
  for (int i = 0; i < division.patterns; ++i) {
    std::string number = std::to_string(i);
    number.insert(0, digits - number.size(), '0');
    patterns.push_back({division.prefix + number, make_uniform_image(projector, 0), division.role});
  }
  for (int y = 0; y < projector.height; ++y) {
    for (int x = 0; x < projector.width; ++x) {
      const Eigen::Vector3d at = square_from_quad * Eigen::Vector3d(x, y, 1.0);
      const double u = at[0] / at[2];
      const double v = at[1] / at[2];
      if (!inside(u) || !inside(v)) continue;
      for (const int pattern : patterns_of(cell_of(u), cell_of(v))) {
        patterns[static_cast<std::size_t>(pattern)].image(x, y) = 255;
      }
    }
  }
  return patterns;
}

}  // namespace

std::vector<std::uint8_t> projector_levels(int count) {
  std::vector<std::uint8_t> values;
  for (int i = 1; i <= count; ++i) values.push_back(grey(static_cast<double>(i) / (count + 1)));
  return values;
}

Image<std::uint8_t> make_uniform_image(const Projector& projector, std::uint8_t value) {
  return {projector.width, projector.height, 1, value};
}

Image<std::uint8_t> make_chessboard_image(const Projector& projector, const ProjectedBoard& board) {
  Image<std::uint8_t> image = make_uniform_image(projector, 0);
  const double square = board.square_px;
  // Inner corners lie between squares, so the squares begin one before the first corner.
  const double left = board.origin_px[0] - square;
  const double top = board.origin_px[1] - square;
  const double right = board.origin_px[0] + square * board.columns;
  const double bottom = board.origin_px[1] + square * board.rows;
  for (int y = 0; y < projector.height; ++y) {
    const double wave_y = mean_wave(y, top, square);
    const double inside_y = coverage(y, top, bottom);
    const double border_y = coverage(y, top - square, bottom + square);
    for (int x = 0; x < projector.width; ++x) {
      const double inside = inside_y * coverage(x, left, right);
      const double border = border_y * coverage(x, left - square, right + square) - inside;
      // The product of two waves of ±1 is a chessboard, +1 in the top left square: black.
      const double white = 0.5 * (1.0 - wave_y * mean_wave(x, left, square));
      image(x, y) = grey(border + inside * white);
    }
  }
  return image;
}

std::vector<PlannedPattern> make_patch_patterns(const Projector& projector,
                                                const ProjectorQuad& quad, int n, double overhang,
                                                PatternRole role, const std::string& prefix) {
  must_be_count(n, "patches along an edge");
  const auto patch_of = [n](int column, int row) { return std::array{row * n + column}; };
  return lit_cells(projector, quad, {n, overhang, n * n, role, prefix}, patch_of);
}

namespace {

std::vector<PlannedPattern> sinusoid_patterns(const Projector& projector, const ProjectorQuad& quad,
                                              const Sinusoids& light,
                                              const std::array<double, 2>& face_mm) {
  constexpr double pi = std::numbers::pi;
  check(face_mm[0] > 0.0 && face_mm[1] > 0.0, "sinusoids need the lit face's extents");
  if (light.phases < 3 || light.phases > 36 || light.per_mm.empty() ||
      light.directions_degrees.empty()) {
    throw InputError("sinusoids need a frequency, a direction and 3 to 36 phases.");
  }
  const Eigen::Matrix3d square_from_quad = quad_from_square(quad).inverse();
  const auto on_face = [&](int x, int y) {  // [mm]
    const Eigen::Vector3d at = square_from_quad * Eigen::Vector3d(x, y, 1.0);
    return Eigen::Vector2d(face_mm[0] * at[0] / at[2], face_mm[1] * at[1] / at[2]);
  };
  const int middle_x = projector.width / 2, middle_y = projector.height / 2;
  const Eigen::Vector2d along_x = on_face(middle_x + 1, middle_y) - on_face(middle_x, middle_y);
  const Eigen::Vector2d along_y = on_face(middle_x, middle_y + 1) - on_face(middle_x, middle_y);
  const double pixel_mm = std::max(along_x.norm(), along_y.norm());
  std::vector<PlannedPattern> patterns;
  for (std::size_t f = 0; f < light.per_mm.size(); ++f) {
    const double per_mm = light.per_mm[f];
    if (!(per_mm > 0.0) || per_mm * pixel_mm > 0.25) {
      throw InputError("a sinusoid of " + std::to_string(per_mm) +
                       " /mm: a period needs more than four projector pixels of " +
                       std::to_string(pixel_mm) + " mm; choose a frequency above 0 and below " +
                       std::to_string(0.25 / pixel_mm) + " /mm.");
    }
    for (std::size_t d = 0; d < light.directions_degrees.size(); ++d) {
      const double angle = light.directions_degrees[d] * pi / 180.0;
      const Eigen::Vector2d wave =
          2.0 * pi * per_mm * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      for (int p = 0; p < light.phases; ++p) {
        char id[64];
        std::snprintf(id, sizeof id, "fit_sine_%02zu_%02zu_%d", f, d, p);
        patterns.push_back({id, make_uniform_image(projector, 0), PatternRole::fit});
        for (int y = 0; y < projector.height; ++y) {
          for (int x = 0; x < projector.width; ++x) {
            const double phase = wave.dot(on_face(x, y)) + 2.0 * pi * p / light.phases;
            patterns.back().image(x, y) = grey(0.5 + 0.5 * std::cos(phase));
          }
        }
      }
    }
  }
  return patterns;
}

}  // namespace

std::vector<PlannedPattern> make_fit_patterns(const Projector& projector, const ProjectorQuad& quad,
                                              const FitLight& light, double overhang,
                                              const std::array<double, 2>& face_mm) {
  const std::string prefix = "fit_";
  const int n = light.n;
  if (light.shape == LightShape::sinusoids) {
    return sinusoid_patterns(projector, quad, light.sinusoids, face_mm);
  }
  if (light.shape == LightShape::patches) {
    return make_patch_patterns(projector, quad, n, overhang, PatternRole::fit, prefix);
  }
  must_be_count(n, "bars across an axis");
  const auto bars_of = [n](int column, int row) { return std::array{column, n + row}; };
  return lit_cells(projector, quad, {n, overhang, 2 * n, PatternRole::fit, prefix}, bars_of);
}

std::vector<Image<std::uint8_t>> make_gray_code_images(const Projector& projector) {
  std::vector<Image<std::uint8_t>> images;
  const auto add = [&](const auto& lit) {
    images.emplace_back(projector.width, projector.height, 1);
    for (int y = 0; y < projector.height; ++y) {
      for (int x = 0; x < projector.width; ++x) images.back()(x, y) = lit(x, y) ? 255 : 0;
    }
  };
  const auto gray = [](int code) { return code ^ (code >> 1); };
  for (const bool columns : {true, false}) {
    const int extent = columns ? projector.width : projector.height;
    for (int bit = std::bit_width(static_cast<unsigned>(extent - 1)) - 1; bit >= 0; --bit) {
      const auto lit = [&](int x, int y) { return (gray(columns ? x : y) >> bit & 1) != 0; };
      add(lit);
      add([&](int x, int y) { return !lit(x, y); });
    }
  }
  images.push_back(make_uniform_image(projector, 255));
  images.push_back(make_uniform_image(projector, 0));
  return images;
}

std::vector<PhaseShift> usual_phase_shift(const Projector& projector) {
  constexpr double ratio = 8.0;
  std::vector<PhaseShift> sets;
  for (const auto along : {PhaseShift::Along::columns, PhaseShift::Along::rows}) {
    const double extent = along == PhaseShift::Along::columns ? projector.width : projector.height;
    for (const double parts : {1.0, ratio, ratio * ratio}) {
      sets.push_back({along, extent / parts, {}});
    }
  }
  return sets;
}

std::size_t finest_set(const std::vector<PhaseShift>& sets) {
  const auto finest = std::min_element(
      sets.begin(), sets.end(),
      [](const PhaseShift& a, const PhaseShift& b) { return a.period_px < b.period_px; });
  return static_cast<std::size_t>(finest - sets.begin());
}

std::vector<Image<std::uint8_t>> make_phase_shift_images(const Projector& projector,
                                                         const PhaseShift& set, int steps) {
  std::vector<Image<std::uint8_t>> images;
  for (int n = 0; n < steps; ++n) {
    Image<std::uint8_t>& image = images.emplace_back(projector.width, projector.height, 1);
    for (int y = 0; y < projector.height; ++y) {
      for (int x = 0; x < projector.width; ++x) {
        const double u = set.along == PhaseShift::Along::columns ? x : y;
        const double turn = u / set.period_px - static_cast<double>(n) / steps;
        image(x, y) = static_cast<std::uint8_t>(
            std::lround(127.5 + 127.5 * std::cos(2.0 * std::numbers::pi * turn)));
      }
    }
  }
  return images;
}

}  // namespace kappamu::capture
