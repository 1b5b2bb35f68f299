#include "tests/cases/inverse_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/appearance_error.h"
#include "core/error.h"
#include "core/numbers/cosine_transform.h"
#include "inverse/problem/objective.h"
#include "inverse/problem/predict.h"
#include "inverse/problem/problem.h"
#include "tests/cases/media.h"

namespace kappamu::test_cases {

namespace {

using inverse::CoefficientPair;

forward::SolveOptions exact(forward::Precision precision) {
  return {precision == forward::Precision::double_precision ? 1e-9 : 1e-6, 1000};
}

/// Waves with up to two half periods across the block, random in phase and direction.
class SmoothField {
 public:
  explicit SmoothField(Noise& noise) {
    for (Wave& wave : waves_) {
      for (double& k : wave.k) k = 2.0 * (2.0 * noise.uniform() - 1.0);
      wave.phase = 2.0 * noise.uniform();
      wave.amplitude = noise.normal();
    }
  }
  /// At a position relative to the block, in [0, 1]³.
  double at(double x, double y, double z) const {
    double sum = 0.0;
    for (const Wave& w : waves_) {
      sum += w.amplitude *
             std::cos(std::numbers::pi * (w.k[0] * x + w.k[1] * y + w.k[2] * z + w.phase));
    }
    return sum;
  }

 private:
  struct Wave {
    std::array<double, 3> k{};
    double phase = 0.0;
    double amplitude = 0.0;
  };
  std::array<Wave, 12> waves_;
};

struct Box {
  std::array<double, 3> low{}, high{};
  bool holds(double x, double y, double z) const {
    return x > low[0] && x < high[0] && y > low[1] && y < high[1] && z > low[2] && z < high[2];
  }
};

/// About a quarter of the block wide, anywhere in it.
Box random_box(Noise& noise) {
  Box box;
  for (std::size_t a = 0; a < 3; ++a) {
    const double width = 0.2 + 0.15 * noise.uniform();
    box.low[a] = (1.0 - width) * noise.uniform();
    box.high[a] = box.low[a] + width;
  }
  return box;
}

/// TruthSpec::embedded; `extent` of the block in mm.
Box embedded_box(Noise& noise, const std::array<double, 3>& extent) {
  constexpr std::array<double, 3> width{3.0, 3.0, 1.5};
  constexpr double around = 1.0;
  Box box;
  for (std::size_t a = 0; a < 3; ++a) {
    const double wide = std::min(width[a], 0.5 * extent[a]);
    const double margin = std::min(around, 0.5 * (extent[a] - wide));
    const double low = margin + (extent[a] - 2.0 * margin - wide) * noise.uniform();
    box.low[a] = low / extent[a];
    box.high[a] = (low + wide) / extent[a];
  }
  return box;
}

bool lit(const SurfaceMeasurements& m, std::size_t sample) {
  return m.lit_face == m.seen_face && m.irradiance[sample] > 0.0F;
}

}  // namespace

double Noise::uniform() {
  return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53;
}

double Noise::normal() {
  const double u = uniform();
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * uniform());
}

CoefficientPair make_truth(const GridShape& shape, const TruthSpec& spec) {
  Noise noise(spec.seed);
  const std::array<SmoothField, 2> fields{SmoothField(noise), SmoothField(noise)};
  const std::array<double, 3> extent{shape.nx * shape.voxel_mm, shape.ny * shape.voxel_mm,
                                     shape.nz * shape.voxel_mm};
  const auto box = [&] { return spec.embedded ? embedded_box(noise, extent) : random_box(noise); };
  const std::array<Box, 2> boxes{box(), box()};
  // Waves are relative to the block's edges, or to its longest one.
  const double longest = *std::max_element(extent.begin(), extent.end());
  std::array<double, 3> reach{1.0, 1.0, 1.0};
  if (spec.embedded) {
    for (std::size_t a = 0; a < 3; ++a) reach[a] = extent[a] / longest;
  }
  const auto field = [&](std::size_t f, double a, double b, double c) {
    return fields[f].at(reach[0] * a, reach[1] * b, reach[2] * c);
  };
  // Extremes of the figures, found on a grid of their own so that they do not hang on `shape`.
  constexpr int samples = 24;
  std::array<double, 2> low{}, high{};
  for (std::size_t f = 0; f < 2; ++f) {
    low[f] = high[f] = field(f, 0.0, 0.0, 0.0);
    for (int i = 0; i < samples * samples * samples; ++i) {
      const double value =
          field(f, (i % samples) / (samples - 1.0), (i / samples % samples) / (samples - 1.0),
                (i / samples / samples) / (samples - 1.0));
      low[f] = std::min(low[f], value);
      high[f] = std::max(high[f], value);
    }
  }
  CoefficientPair truth{std::vector<double>(shape.cells()), std::vector<double>(shape.cells())};
  const double range = std::log(spec.contrast);
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const double a = (x + 0.5) / shape.nx, b = (y + 0.5) / shape.ny, c = (z + 0.5) / shape.nz;
        const auto smooth = [&](std::size_t f) {
          return range * ((field(f, a, b, c) - low[f]) / (high[f] - low[f]) - 0.5);
        };
        const std::size_t i = shape.index(x, y, z);
        truth.log_kappa[i] = std::log(spec.kappa) + smooth(0);
        truth.log_mu[i] = std::log(spec.mu) + smooth(1);
        if (!spec.inclusions) continue;
        if (boxes[0].holds(a, b, c)) truth.log_kappa[i] -= spec.embedded ? std::log(3.0) : range;
        if (boxes[1].holds(a, b, c)) truth.log_mu[i] += range;
      }
    }
  }
  return truth;
}

std::vector<double> single_voxel_light(FaceShape face, int count, std::uint64_t seed) {
  check(count >= 1, "single_voxel_light: at least one source");
  std::mt19937_64 engine(seed);
  std::vector<double> light(face.cells() * static_cast<std::size_t>(count), 0.0);
  // One voxel by chance from each of `count` equal stretches of the face: spread, without repeats.
  const std::size_t stretch =
      std::max<std::size_t>(1, face.cells() / static_cast<std::size_t>(count));
  for (std::size_t m = 0; m < static_cast<std::size_t>(count); ++m) {
    light[m * face.cells() + (m * stretch + engine() % stretch) % face.cells()] = 1.0;
  }
  return light;
}

SurfaceMeasurements expose(const Block& block, const CoefficientPair& fine_fields,
                           const std::vector<double>& irradiance) {
  SurfaceMeasurements m;
  m.grid = block.grid;
  m.lit_face = block.lit;
  m.seen_face = block.seen;
  m.light = block.light;
  m.quantity = block.quantity;
  m.channels = {"grey"};
  m.patterns = static_cast<int>(irradiance.size() / m.lit_shape().cells());
  m.irradiance.assign(irradiance.begin(), irradiance.end());
  const forward::GridSetup setup = inverse::make_setup(m, forward::Convention::physical);
  forward::GridSetup fine = setup;
  fine.shape = setup.shape.refined(2);
  const auto op = forward::block_operators()->make(fine, block.seen, "auto", block.precision).op;
  op->set_medium(inverse::exponential(fine_fields.log_kappa),
                 inverse::exponential(fine_fields.log_mu));
  const std::vector<double> light = inverse::split_face(
      irradiance, m.lit_shape(), face_shape(fine.shape, block.lit), 2, m.patterns);
  constexpr double memory_mb = 4096.0;
  const int batch = inverse::bounded_batch(fine.shape, 16, memory_mb, block.precision);
  const std::vector<double> exitance = inverse::restrict_face(
      inverse::solve_exitance(*op, light, m.patterns, {batch, exact(block.precision)}),
      face_shape(fine.shape, block.seen), m.seen_shape(), 2, m.patterns);
  const double scale = 1.0 / inverse::exitance_per_value(m, setup);
  for (const double x : exitance) m.value.push_back(static_cast<float>(scale * x));
  m.variance.assign(m.value.size(), 1.0F);
  return m;
}

SurfaceMeasurements expose_patches(const Block& block, const CoefficientPair& fine_fields,
                                   int side) {
  return expose(block, fine_fields, patch_light(block.grid, block.lit, side * side));
}

void add_noise(SurfaceMeasurements& m, double relative, std::uint64_t seed) {
  Noise noise(seed);
  const std::size_t cells = m.seen_shape().cells();
  if (m.lit_face == m.seen_face) m.mask.assign(m.value.size(), 1);
  for (std::size_t p = 0; p < static_cast<std::size_t>(m.patterns); ++p) {
    float largest = 0.0F;
    for (std::size_t i = p * cells; i < (p + 1) * cells; ++i) {
      if (lit(m, i)) m.mask[i] = 0;
      if (!lit(m, i)) largest = std::max(largest, m.value[i]);
    }
    for (std::size_t i = p * cells; i < (p + 1) * cells; ++i) {
      const double sigma = relative * (m.value[i] + relative * largest);
      m.value[i] += static_cast<float>(sigma * noise.normal());
      m.variance[i] = static_cast<float>(sigma * sigma);
    }
  }
}

void add_smooth_error(SurfaceMeasurements& measurements, const SmoothError& error, Noise& noise) {
  const FaceShape face = measurements.seen_shape();
  const CosineTransform cosines_u(face.nu), cosines_v(face.nv);
  const double lowest = 0.25 / static_cast<double>(face.cells());
  const auto draw = [&](double size) {
    Eigen::MatrixXd waves(face.nu, face.nv);
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const double f2 =
            std::max(lowest, std::pow(0.5 * u / face.nu, 2) + std::pow(0.5 * v / face.nv, 2));
        waves(u, v) =
            size * noise.normal() / std::sqrt(2.0 * std::numbers::pi * std::numbers::ln2 * f2);
      }
    }
    return from_waves(cosines_u, cosines_v, waves);
  };
  const Eigen::MatrixXd common = draw(error.common);
  for (int m = 0; m < measurements.patterns; ++m) {
    const Eigen::MatrixXd gain = common + draw(error.own);
    for (std::size_t i = 0; i < face.cells(); ++i) {
      measurements.value[static_cast<std::size_t>(m) * face.cells() + i] *=
          static_cast<float>(1.0 + gain.data()[i]);
    }
  }
}

SurfaceMeasurements measure(const Block& block, const CoefficientPair& fine_fields, int side,
                            std::uint64_t seed) {
  SurfaceMeasurements m = expose_patches(block, fine_fields, side);
  add_noise(m, block.noise, seed);
  return m;
}

double appearance_error(const Medium& medium, const SurfaceMeasurements& exposed,
                        const inverse::PredictOptions& how) {
  const std::vector<float> predicted = inverse::predict(medium, exposed, how);
  AppearanceError error;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (lit(exposed, i) || (!exposed.mask.empty() && exposed.mask[i] == 0)) continue;
    error.add(predicted[i], exposed.value[i]);
  }
  return error.E();
}

}  // namespace kappamu::test_cases
