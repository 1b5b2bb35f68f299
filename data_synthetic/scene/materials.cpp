#include "data_synthetic/scene/materials.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/numbers/noise.h"
#include "core/parallel.h"
#include "core/random.h"

namespace kappamu::synthetic {

namespace {

using Eigen::Vector3d;

/// What a feature does to the coefficients where it is fully present.
struct Tint {
  std::array<double, 3> scattering{1.0, 1.0, 1.0};  ///< factors on σs'
  std::array<double, 3> absorption{1.0, 1.0, 1.0};  ///< factors on μ
};

/// Applies a tint with weight in [0, 1], geometrically, so that coefficients stay positive.
void apply(PointCoefficients& point, const Tint& tint, double weight) {
  for (int c = 0; c < 3; ++c) {
    point.scattering[c] *= std::pow(tint.scattering[c], weight);
    point.absorption[c] *= std::pow(tint.absorption[c], weight);
  }
}

/// Smooth, slow variation of both coefficients: factors exp(±strength).
void vary(PointCoefficients& point, const Vector3d& x, double size, double scattering_strength,
          double absorption_strength, std::uint64_t seed) {
  const double scattering = std::exp(scattering_strength * layered_noise(x, size, 2, mix(seed)));
  const double absorption =
      std::exp(absorption_strength * layered_noise(x, size, 2, mix(seed + 1)));
  for (int c = 0; c < 3; ++c) {
    point.scattering[c] *= scattering;
    point.absorption[c] *= absorption;
  }
}

/// 1 inside, 0 outside, with a C1 ramp of `softness` [mm] about the surface; `distance` is signed,
/// negative inside.
double inside(double distance, double softness) {
  const double t = std::clamp(0.5 - distance / softness, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double ellipsoid_distance(const Vector3d& x, const Vector3d& centre, const Vector3d& radii) {
  const double scaled = (x - centre).cwiseQuotient(radii).norm();
  return (scaled - 1.0) * radii.minCoeff();
}

/// A sheet through the block, bent by noise: distance to its middle, minus half its thickness.
double vein_distance(const Vector3d& x, const Vector3d& normal, double offset, double bend_mm,
                     double bend_size_mm, double thickness_mm, std::uint64_t seed) {
  const double bend = bend_mm * layered_noise(x, bend_size_mm, 2, seed);
  return std::abs(x.dot(normal.normalized()) - offset + bend) - 0.5 * thickness_mm;
}

constexpr PointCoefficients jensen_marble{{2.19, 2.62, 3.00}, {0.0021, 0.0041, 0.0071}};
/// Onyx-like stone, clear enough that the demo's voxels stay below a mean free path.
constexpr PointCoefficients onyx{{1.14, 1.23, 1.33}, {0.0021, 0.0041, 0.0071}};

Vector3d extent(const GridShape& grid) {
  return Vector3d(grid.nx, grid.ny, grid.nz) * grid.voxel_mm;
}

/// One grey vein, a clear inclusion and a reddish absorbing one in `base`.
auto vein_and_inclusions(const PointCoefficients& base, const GridShape& grid, std::uint64_t seed) {
  const Vector3d size = extent(grid);
  const double voxel = grid.voxel_mm;
  return [=](const Vector3d& x) {
    PointCoefficients point = base;
    vary(point, x, 6.0, 0.45, 0.6, seed);
    const double vein = vein_distance(x, {1.0, 0.55, 0.35}, 0.52 * size.x() + 0.2 * size.y(), 2.5,
                                      9.0, 3.0 * voxel, mix(seed + 7));
    apply(point, {{0.6, 0.6, 0.65}, {5.0, 4.0, 3.0}}, inside(vein, 2.0 * voxel));
    const double clear = ellipsoid_distance(x, size.cwiseProduct(Vector3d(0.27, 0.68, 0.45)),
                                            Vector3d(5.5, 4.5, 3.0) * voxel);
    apply(point, {{0.4, 0.4, 0.4}, {1.5, 1.5, 1.5}}, inside(clear, 1.5 * voxel));
    const double stained = ellipsoid_distance(x, size.cwiseProduct(Vector3d(0.74, 0.3, 0.55)),
                                              Vector3d(4.5, 4.5, 2.8) * voxel);
    apply(point, {{1.2, 1.2, 1.2}, {3.0, 6.0, 7.0}}, inside(stained, 1.5 * voxel));
    return point;
  };
}

/// Marble with a net of veins of several widths.
auto marble_coefficients(const GridShape& grid, std::uint64_t seed) {
  const Vector3d size = extent(grid);
  const double voxel = grid.voxel_mm;
  return [=](const Vector3d& x) {
    PointCoefficients point = jensen_marble;
    vary(point, x, 20.0, 0.4, 0.6, seed);
    for (std::uint64_t v = 0; v < 7; ++v) {
      const double angle = std::numbers::pi * uniform(key_of({seed, 11, v}));
      const Vector3d normal(std::cos(angle), std::sin(angle), uniform(key_of({seed, 12, v})) - 0.5);
      const double offset =
          size.dot(normal.normalized()) * (0.15 + 0.7 * uniform(key_of({seed, 13, v})));
      const double thickness = voxel * (2.0 + 3.0 * uniform(key_of({seed, 14, v})));
      const double vein =
          vein_distance(x, normal, offset, 9.0, 30.0, thickness, key_of({seed, 15, v}));
      apply(point, {{0.65, 0.65, 0.7}, {4.0, 3.5, 2.8}}, inside(vein, 2.0 * voxel));
    }
    return point;
  };
}

/// Layers of two waxes folded into each other.
auto wax_coefficients(const PointCoefficients& base, const Tint& second, std::uint64_t seed) {
  return [=](const Vector3d& x) {
    PointCoefficients point = base;
    vary(point, x, 12.0, 0.3, 0.5, seed);
    const double folds = std::sin(
        2.0 * std::numbers::pi *
        (x.dot(Vector3d(0.05, 0.03, 0.06)) + 0.5 * layered_noise(x, 16.0, 2, mix(seed + 3))));
    apply(point, second, 0.5 + 0.5 * std::tanh(2.5 * folds));
    return point;
  };
}

/// Cast stone: round grains of two kinds in a clear binder, one grain per cell of a jittered
/// lattice.
auto stone_coefficients(double voxel, std::uint64_t seed) {
  return [=](const Vector3d& x) {
    PointCoefficients point{{1.00, 1.20, 1.40}, {0.003, 0.005, 0.010}};
    vary(point, x, 14.0, 0.25, 0.4, seed);
    constexpr double spacing = 5.0;  // mm
    const Vector3d home = (x / spacing).array().floor();
    for (int n = 0; n < 27; ++n) {
      const std::array<int, 3> step{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
      const Vector3d cell = home + Vector3d(step[0], step[1], step[2]);
      const auto part = [&](int i) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(cell[i]));
      };
      const std::uint64_t grain = key_of({seed, 21, part(0), part(1), part(2)});
      const double kind = uniform(mix(grain + 4));
      if (kind > 0.75) continue;
      const Vector3d jitter(uniform(grain), uniform(mix(grain + 1)), uniform(mix(grain + 2)));
      const Vector3d centre = (cell + Vector3d::Constant(0.2) + 0.6 * jitter) * spacing;
      const double radius = 1.0 + 1.2 * uniform(mix(grain + 3));
      const double weight = inside((x - centre).norm() - radius, 2.0 * voxel);
      if (kind < 0.45) {
        apply(point, {{2.0, 1.9, 1.8}, {1.0, 1.0, 1.0}}, weight);
      } else {
        apply(point, {{0.8, 0.8, 0.9}, {5.0, 6.0, 4.0}}, weight);
      }
    }
    return point;
  };
}

/// A reference phantom: even, thick, absorbing enough that its sides are not felt in the middle.
constexpr PointCoefficients silicone{{2.0, 2.2, 2.4}, {0.03, 0.05, 0.08}};
constexpr double silicone_index = 1.4;
constexpr PointCoefficients pale_wax{{1.20, 1.40, 1.60}, {0.002, 0.005, 0.020}};
constexpr Tint amber_wax{{0.6, 0.65, 0.7}, {2.0, 2.5, 2.2}};
constexpr PointCoefficients candle_wax{{1.40, 1.60, 1.80}, {0.003, 0.006, 0.015}};
constexpr Tint red_wax{{0.8, 0.75, 0.75}, {1.5, 5.0, 3.5}};

}  // namespace

std::vector<std::string> sample_names() {
  return {"demo", "wax1", "wax2", "marble", "stone", "tiny", "phantom"};
}

SampleModel make_sample(const std::string& name, std::uint64_t seed,
                        std::optional<std::array<int, 3>> grid) {
  SampleModel sample;
  sample.name = name;
  const std::uint64_t structure = key_of({seed, 0x5A});
  const auto shape = [&](int nx, int ny, int nz, double voxel_mm) {
    sample.grid = {nx, ny, nz, voxel_mm};
    if (grid) sample.grid = {(*grid)[0], (*grid)[1], (*grid)[2], voxel_mm};
  };
  if (name == "demo") {
    shape(40, 32, 12, 0.5);
    sample.coefficients = vein_and_inclusions(onyx, sample.grid, structure);
  } else if (name == "tiny") {
    shape(12, 10, 6, 0.6);
    sample.coefficients = vein_and_inclusions(jensen_marble, sample.grid, structure);
  } else if (name == "phantom") {
    shape(48, 48, 24, 0.5);
    sample.setup = capture::Setup::front_lit;
    sample.eta = silicone_index;
    sample.coefficients = [](const Vector3d&) { return silicone; };
  } else if (name == "wax1") {
    shape(130, 53, 37, 0.4);
    sample.coefficients = wax_coefficients(pale_wax, amber_wax, structure);
  } else if (name == "wax2") {
    shape(140, 75, 48, 0.4);
    sample.setup = capture::Setup::front_lit;
    sample.coefficients = wax_coefficients(candle_wax, red_wax, structure);
  } else if (name == "marble") {
    shape(256, 256, 20, 0.5);
    sample.coefficients = marble_coefficients(sample.grid, structure);
  } else if (name == "stone") {
    shape(128, 128, 41, 0.4);
    sample.coefficients = stone_coefficients(sample.grid.voxel_mm, structure);
  } else {
    std::string names;
    for (const std::string& known : sample_names()) names += (names.empty() ? "" : ", ") + known;
    throw InputError("unknown sample \"" + name + "\": choose one of " + names);
  }
  return sample;
}

std::array<Medium, 3> sample_medium(const SampleModel& sample, const GridShape& shape) {
  std::array<Medium, 3> media;
  for (Medium& medium : media) medium = {Volume<double>(shape), Volume<double>(shape)};
  for_rows(shape.ny * shape.nz, [&](int row) {
    const int y = row % shape.ny;
    const int z = row / shape.ny;
    for (int x = 0; x < shape.nx; ++x) {
      const Vector3d centre = (Vector3d(x, y, z) + Vector3d::Constant(0.5)) * shape.voxel_mm;
      const PointCoefficients point = sample.coefficients(centre);
      for (int c = 0; c < 3; ++c) {
        media[c].mu(x, y, z) = point.absorption[c];
        media[c].kappa(x, y, z) = 1.0 / (3.0 * (point.absorption[c] + point.scattering[c]));
      }
    }
  });
  return media;
}

}  // namespace kappamu::synthetic
