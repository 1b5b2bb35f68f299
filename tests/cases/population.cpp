#include "tests/cases/population.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace kappamu::test_cases {

namespace {

using inverse::CoefficientPair;
using Point = std::array<double, 3>;  // mm

constexpr double kappa_mm = 0.2;    // geometric means of all families
constexpr double mu_per_mm = 0.01;  // the same

/// In [low, high], even in the logarithm.
double log_even(Noise& noise, double low, double high) {
  return low * std::pow(high / low, noise.uniform());
}

/// Adds to the logarithms at a point: κ's first.
using Figure = std::function<std::array<double, 2>(const Point&)>;

Figure layers(Noise& noise, const Point& extent) {
  std::vector<double> ends;
  const int count = 2 + static_cast<int>(3.0 * noise.uniform());
  for (int k = 1; k < count; ++k) {
    ends.push_back(extent[2] * (k + 0.6 * (noise.uniform() - 0.5)) / count);
  }
  std::vector<std::array<double, 2>> values;
  for (int k = 0; k < count; ++k) {
    values.push_back(
        {std::log(log_even(noise, 0.5, 2.0)), std::log(log_even(noise, 1.0 / 3.0, 3.0))});
  }
  struct Ball {
    Point middle;
    double radius;
    std::array<double, 2> change;
  };
  std::vector<Ball> balls;
  for (int k = 0; k < 2; ++k) {
    Ball ball{};
    ball.radius = extent[2] * (0.15 + 0.2 * noise.uniform());
    for (std::size_t a = 0; a < 3; ++a) {
      ball.middle[a] = ball.radius + (extent[a] - 2.0 * ball.radius) * noise.uniform();
    }
    ball.change = k == 0 ? std::array{-std::log(3.0), 0.0} : std::array{0.0, std::log(4.0)};
    balls.push_back(ball);
  }
  return [=](const Point& p) {
    const auto layer = std::upper_bound(ends.begin(), ends.end(), p[2]) - ends.begin();
    std::array<double, 2> sum = values[static_cast<std::size_t>(layer)];
    for (const Ball& ball : balls) {
      double square = 0.0;
      for (std::size_t a = 0; a < 3; ++a) square += std::pow(p[a] - ball.middle[a], 2);
      if (square > ball.radius * ball.radius) continue;
      for (std::size_t f = 0; f < 2; ++f) sum[f] += ball.change[f];
    }
    return sum;
  };
}

/// |distance| to a plane bent by two waves, less than half of the sheet's thickness.
Figure veins(Noise& noise, const Point& extent, double voxel_mm) {
  struct Sheet {
    Point normal, through;
    std::array<Point, 2> wave;  // [1/mm]
    std::array<double, 2> phase, height;
    double half;
  };
  std::vector<Sheet> sheets;
  for (int k = 0; k < 3; ++k) {
    Sheet sheet{};
    double length = 0.0;
    for (std::size_t a = 0; a < 3; ++a) {
      sheet.normal[a] = noise.normal();
      length += sheet.normal[a] * sheet.normal[a];
      sheet.through[a] = extent[a] * (0.2 + 0.6 * noise.uniform());
    }
    for (double& n : sheet.normal) n /= std::sqrt(length);
    for (std::size_t w = 0; w < 2; ++w) {
      const double wavelength = extent[0] * (0.3 + 0.5 * noise.uniform());
      for (double& c : sheet.wave[w]) {
        c = 2.0 * std::numbers::pi / wavelength * (2.0 * noise.uniform() - 1.0);
      }
      sheet.phase[w] = 2.0 * std::numbers::pi * noise.uniform();
      sheet.height[w] = 0.08 * extent[0] * noise.uniform();
    }
    sheet.half = 0.5 * voxel_mm * log_even(noise, 0.5, 2.0);
    sheets.push_back(sheet);
  }
  return [=](const Point& p) -> std::array<double, 2> {
    for (const Sheet& s : sheets) {
      double distance = 0.0;
      for (std::size_t a = 0; a < 3; ++a) distance += s.normal[a] * (p[a] - s.through[a]);
      for (std::size_t w = 0; w < 2; ++w) {
        double phase = s.phase[w];
        for (std::size_t a = 0; a < 3; ++a) phase += s.wave[w][a] * p[a];
        distance += s.height[w] * std::sin(phase);
      }
      if (std::abs(distance) < s.half) return {-std::log(2.5), std::log(5.0)};
    }
    return {0.0, 0.0};
  };
}

Figure figures(Noise& noise, const Point& extent) {
  struct Shape {
    int kind;
    double x, y, size, turn, top, bottom;
    std::array<double, 2> change;
  };
  std::vector<Shape> shapes;
  for (int kind = 0; kind < 3; ++kind) {
    Shape s{};
    s.kind = kind;
    s.size = extent[0] * (0.12 + 0.08 * noise.uniform());
    s.x = s.size + (extent[0] - 2.0 * s.size) * noise.uniform();
    s.y = s.size + (extent[1] - 2.0 * s.size) * noise.uniform();
    s.turn = std::numbers::pi * noise.uniform();
    s.top = 0.6 * extent[2] * noise.uniform();
    s.bottom = s.top + 0.4 * extent[2];
    const double kappa = std::log(log_even(noise, 2.0, 4.0));
    const double mu = std::log(log_even(noise, 2.0, 5.0));
    s.change = {noise.uniform() < 0.7 ? -kappa : kappa, noise.uniform() < 0.7 ? mu : -mu};
    shapes.push_back(s);
  }
  return [=](const Point& p) {
    std::array<double, 2> sum{0.0, 0.0};
    for (const Shape& s : shapes) {
      if (p[2] < s.top || p[2] > s.bottom) continue;
      const double x = p[0] - s.x, y = p[1] - s.y;
      const double along = std::cos(s.turn) * x + std::sin(s.turn) * y;
      const double across = std::cos(s.turn) * y - std::sin(s.turn) * x;
      const double radius = std::hypot(x, y);
      const bool bar = std::abs(along) < s.size && std::abs(across) < 0.35 * s.size;
      const bool within = s.kind == 0   ? bar
                          : s.kind == 1 ? radius < 0.8 * s.size
                                        : radius < s.size && radius > 0.5 * s.size;
      if (!within) continue;
      for (std::size_t f = 0; f < 2; ++f) sum[f] += s.change[f];
    }
    return sum;
  };
}

}  // namespace

CoefficientPair make_family(const GridShape& shape, Family family, double voxel_mm,
                            std::uint64_t seed) {
  TruthSpec smooth;
  smooth.seed = seed;
  if (family == Family::boxes) return make_truth(shape, smooth);
  // Families of one seed share no random numbers.
  Noise noise(4 * seed + static_cast<std::uint64_t>(family));
  const Point extent{shape.nx * shape.voxel_mm, shape.ny * shape.voxel_mm,
                     shape.nz * shape.voxel_mm};
  CoefficientPair fields{std::vector<double>(shape.cells(), std::log(kappa_mm)),
                         std::vector<double>(shape.cells(), std::log(mu_per_mm))};
  Figure figure;
  switch (family) {
    case Family::layers:
      figure = layers(noise, extent);
      break;
    case Family::veins:
      smooth.inclusions = false;
      smooth.contrast = 2.0;
      fields = make_truth(shape, smooth);
      figure = veins(noise, extent, voxel_mm);
      break;
    default:
      figure = figures(noise, extent);
  }
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const auto at = [&](int i) { return (i + 0.5) * shape.voxel_mm; };
        const std::array<double, 2> change = figure({at(x), at(y), at(z)});
        const std::size_t i = shape.index(x, y, z);
        fields.log_kappa[i] += change[0];
        fields.log_mu[i] += change[1];
      }
    }
  }
  return fields;
}

}  // namespace kappamu::test_cases
