#include "tests/cases/media.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "core/error.h"

namespace kappamu::test_cases {

namespace {

constexpr std::array<std::pair<MediumKind, const char*>, 7> names{{
    {MediumKind::uniform, "uniform"},
    {MediumKind::smooth, "smooth"},
    {MediumKind::inclusions, "inclusions"},
    {MediumKind::checkerboard, "checkerboard"},
    {MediumKind::layers, "layers"},
    {MediumKind::random, "random"},
    {MediumKind::shell, "shell"},
}};

/// A figure of log κ in any scale: its extremes become `contrast` apart.
using Figure = std::vector<double>;

template <class F>
Figure figure_of(const GridShape& shape, F value) {
  Figure figure(shape.cells());
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) figure[shape.index(x, y, z)] = value(x, y, z);
    }
  }
  return figure;
}

/// Uniform on [0, 1) from the generator's own bits: standard distributions differ between
/// libraries.
double fraction(std::mt19937& generator) {
  return static_cast<double>(generator()) / 4294967296.0;
}

Figure smooth(const GridShape& shape) {
  const auto wave = [](int i, int extent, double turns) {
    return std::cos(2.0 * std::numbers::pi * turns * (i + 0.5) / extent);
  };
  return figure_of(shape, [&](int x, int y, int z) {
    return wave(x, shape.nx, 1.5) + wave(y, shape.ny, 1.0) + wave(z, shape.nz, 0.5);
  });
}

/// Balls on a jittered lattice with about five across the block's middle extent, so that refining
/// the grid shows the same balls larger. Lattice neighbours differ in sign.
Figure inclusions(const GridShape& shape, unsigned seed) {
  constexpr double across = 5.0, radius_per_pitch = 0.35, radius_per_thickness = 0.4, jitter = 0.1;
  std::array<int, 3> extent{shape.nx, shape.ny, shape.nz};
  std::array<int, 3> sorted = extent;
  std::sort(sorted.begin(), sorted.end());
  const double pitch = std::max(2.0, sorted[1] / across);
  const double radius =
      std::max(0.75, std::min(radius_per_pitch * pitch, radius_per_thickness * sorted[0]));
  std::array<int, 3> count{};
  for (std::size_t a = 0; a < 3; ++a) {
    count[a] = std::max(1, static_cast<int>(std::lround(extent[a] / pitch)));
  }
  std::mt19937 generator(seed);
  Figure figure(shape.cells(), 0.0);
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        const std::array<int, 3> site{i, j, k};
        std::array<double, 3> centre{};
        std::array<int, 3> first{}, last{};
        for (std::size_t a = 0; a < 3; ++a) {
          const double step = static_cast<double>(extent[a]) / count[a];
          centre[a] = step * (site[a] + 0.5 + jitter * (2.0 * fraction(generator) - 1.0));
          first[a] = std::max(0, static_cast<int>(centre[a] - radius) - 1);
          last[a] = std::min(extent[a] - 1, static_cast<int>(centre[a] + radius) + 1);
        }
        for (int z = first[2]; z <= last[2]; ++z) {
          for (int y = first[1]; y <= last[1]; ++y) {
            for (int x = first[0]; x <= last[0]; ++x) {
              const double distance =
                  std::hypot(x + 0.5 - centre[0], y + 0.5 - centre[1], z + 0.5 - centre[2]);
              if (distance <= radius) {
                figure[shape.index(x, y, z)] = (i + j + k) % 2 == 0 ? 0.5 : -0.5;
              }
            }
          }
        }
      }
    }
  }
  return figure;
}

Figure random_cubes(const GridShape& shape, int period, unsigned seed) {
  const auto cubes = [&](int extent) { return (extent + period - 1) / period; };
  const GridShape coarse{cubes(shape.nx), cubes(shape.ny), cubes(shape.nz), 1.0};
  std::mt19937 generator(seed);
  Figure values(coarse.cells());
  for (double& value : values) value = fraction(generator);
  return figure_of(shape, [&](int x, int y, int z) {
    return values[coarse.index(x / period, y / period, z / period)];
  });
}

Figure figure_of(const GridShape& shape, const MediumSpec& spec) {
  const int period = spec.period;
  switch (spec.kind) {
    case MediumKind::uniform:
      return Figure(shape.cells(), 0.0);
    case MediumKind::smooth:
      return smooth(shape);
    case MediumKind::inclusions:
      return inclusions(shape, spec.seed);
    case MediumKind::checkerboard:
      return figure_of(shape, [&](int x, int y, int z) {
        return (x / period + y / period + z / period) % 2 == 0 ? 1.0 : 0.0;
      });
    case MediumKind::layers:
      return figure_of(shape, [&](int x, int y, int z) {
        const int along = spec.axis == 0 ? x : spec.axis == 1 ? y : z;
        return along / period % 2 == 0 ? 1.0 : 0.0;
      });
    case MediumKind::random:
      return random_cubes(shape, period, spec.seed);
    case MediumKind::shell:
      return figure_of(shape, [&](int x, int y, int z) {
        const bool inside =
            x > 0 && y > 0 && z > 0 && x + 1 < shape.nx && y + 1 < shape.ny && z + 1 < shape.nz;
        return inside ? 1.0 : 0.0;
      });
  }
  throw InternalError("make_medium: unknown kind");
}

/// Stretches a figure so that its extremes lie log(contrast) apart; an even one stays as it is.
void stretch(Figure& figure, double contrast) {
  const auto [low, high] = std::minmax_element(figure.begin(), figure.end());
  const double range = *high - *low;
  if (range <= 0.0) return;
  const double factor = std::log(contrast) / range;
  for (double& value : figure) value *= factor;
}

void validate(const GridShape& shape, const MediumSpec& spec) {
  const auto need = [](bool holds, const char* sentence) {
    if (!holds) throw InputError(sentence);
  };
  need(shape.nx > 0 && shape.ny > 0 && shape.nz > 0, "grid: every extent must be positive.");
  need(spec.contrast > 0.0 && std::isfinite(spec.contrast), "contrast must be positive.");
  need(spec.background_contrast > 0.0 && std::isfinite(spec.background_contrast),
       "background_contrast must be positive.");
  need(spec.mean_kappa > 0.0 && std::isfinite(spec.mean_kappa), "mean_kappa must be positive.");
  need(spec.mu >= 0.0 && std::isfinite(spec.mu), "mu must be zero or positive.");
  need(spec.period > 0, "period must be at least one voxel.");
  need(spec.axis >= 0 && spec.axis <= 2, "axis must be 0, 1 or 2.");
}

}  // namespace

std::string to_string(MediumKind kind) {
  for (const auto& [known, name] : names) {
    if (known == kind) return name;
  }
  throw InternalError("to_string: unknown medium kind");
}

Medium make_medium(const GridShape& shape, const MediumSpec& spec) {
  validate(shape, spec);
  Figure log_kappa = figure_of(shape, spec);
  stretch(log_kappa, spec.contrast);
  if (spec.background_contrast != 1.0) {
    Figure background = smooth(shape);
    stretch(background, spec.background_contrast);
    for (std::size_t i = 0; i < log_kappa.size(); ++i) log_kappa[i] += background[i];
  }
  double mean = 0.0;
  for (const double value : log_kappa) mean += value;
  mean /= static_cast<double>(log_kappa.size());
  for (double& value : log_kappa) value = spec.mean_kappa * std::exp(value - mean);
  return {Volume<double>(shape, std::move(log_kappa)), Volume<double>(shape, spec.mu)};
}

MediumSpec reference_inclusions() {
  return {.kind = MediumKind::inclusions, .contrast = 1e4, .background_contrast = 10.0};
}

std::vector<double> patch_light(const GridShape& shape, Face lit_face, int patterns) {
  check(patterns >= 1, "patch_light: at least one pattern");
  const FaceShape face = face_shape(shape, lit_face);
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(patterns))));
  const int rows = (patterns + columns - 1) / columns;
  std::vector<double> light(face.cells() * static_cast<std::size_t>(patterns), 0.0);
  // Patch `at` of `parts` covers [at·n/parts, (at+1)·n/parts), at least one voxel.
  const auto first = [](int at, int parts, int n) { return at * n / parts; };
  const auto end = [&](int at, int parts, int n) {
    return std::max(first(at, parts, n) + 1, first(at + 1, parts, n));
  };
  for (int m = 0; m < patterns; ++m) {
    const int column = m % columns, row = m / columns;
    double* map = light.data() + face.cells() * static_cast<std::size_t>(m);
    for (int v = first(row, rows, face.nv); v < end(row, rows, face.nv); ++v) {
      for (int u = first(column, columns, face.nu); u < end(column, columns, face.nu); ++u) {
        map[static_cast<std::size_t>(v) * static_cast<std::size_t>(face.nu) + u] = 1.0;
      }
    }
  }
  return light;
}

std::vector<double> bar_light(const GridShape& shape, Face lit_face, int bars) {
  check(bars >= 1, "bar_light: at least one bar");
  const FaceShape face = face_shape(shape, lit_face);
  const auto n = static_cast<std::size_t>(bars);
  std::vector<double> light(face.cells() * 2 * n, 0.0);
  std::size_t cell = 0;
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u, ++cell) {
      light[static_cast<std::size_t>(u * bars / face.nu) * face.cells() + cell] = 1.0;
      light[(n + static_cast<std::size_t>(v * bars / face.nv)) * face.cells() + cell] = 1.0;
    }
  }
  return light;
}

}  // namespace kappamu::test_cases
