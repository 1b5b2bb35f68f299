#include "tests/inverse/block_model/systematic_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/cases/inverse_case.h"

namespace kappamu::test_cases {

namespace {

/// One pattern's values as a smooth function of place (Catmull and Rom's cubic), pixel centres at
/// whole numbers.
class Image {
 public:
  Image(const float* values, FaceShape face) : values_(values), face_(face) {}

  double operator()(double u, double v) const {
    const std::array<double, 4> across = cubic(u);
    const std::array<double, 4> down = cubic(v);
    const int left = static_cast<int>(std::floor(u)) - 1;
    const int top = static_cast<int>(std::floor(v)) - 1;
    double sum = 0.0;
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        const int at =
            std::clamp(top + j, 0, face_.nv - 1) * face_.nu + std::clamp(left + i, 0, face_.nu - 1);
        sum +=
            down[static_cast<std::size_t>(j)] * across[static_cast<std::size_t>(i)] * values_[at];
      }
    }
    return sum;
  }

 private:
  static std::array<double, 4> cubic(double position) {
    const double t = position - std::floor(position);
    return {0.5 * t * (-1.0 + t * (2.0 - t)), 0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
            0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
  }

  const float* values_;
  FaceShape face_;
};

/// The image as a camera of pixels `pitch` voxels wide has it, linearly interpolated between them.
double interpolated(const Image& image, double u, double v, double pitch, double offset_u,
                    double offset_v) {
  const double i = std::floor((u - offset_u) / pitch);
  const double j = std::floor((v - offset_v) / pitch);
  const double s = (u - offset_u) / pitch - i;
  const double t = (v - offset_v) / pitch - j;
  const auto at = [&](double a, double b) {
    return image(offset_u + pitch * (i + a), offset_v + pitch * (j + b));
  };
  return (1.0 - t) * ((1.0 - s) * at(0, 0) + s * at(1, 0)) +
         t * ((1.0 - s) * at(0, 1) + s * at(1, 1));
}

/// Adds `errors`, relative to the values, as large as `size` in all.
void add(SurfaceMeasurements& m, const std::vector<double>& errors, double size) {
  double squares = 0.0;
  for (const double e : errors) squares += e * e;
  const double scale = size / std::sqrt(squares / static_cast<double>(errors.size()));
  for (std::size_t i = 0; i < errors.size(); ++i) {
    m.value[i] *= static_cast<float>(1.0 + scale * errors[i]);
  }
}

}  // namespace

std::vector<double> bar_light(const GridShape& grid, int count) {
  std::vector<double> light;
  for (int m = 0; m < count; ++m) {
    for (int i = 0; i < grid.nx * grid.ny; ++i) {
      light.push_back(i % grid.nx * count / grid.nx == m ? 1.0 : 0.0);
    }
  }
  return light;
}

void add_rig_error(SurfaceMeasurements& m, double size, std::uint64_t seed) {
  Noise chance(seed);
  const double pitch = 0.7 + 0.9 * chance.uniform();
  const double offset_u = pitch * chance.uniform();
  const double offset_v = pitch * chance.uniform();
  const std::array<double, 2> shift{0.05 * chance.normal(), 0.05 * chance.normal()};
  std::array<double, 3> share{};
  for (double& x : share) x = chance.normal();
  const float largest = *std::max_element(m.value.begin(), m.value.end());
  const FaceShape face = m.seen_shape();
  std::array<std::vector<double>, 3> parts;
  std::array<double, 3> squares{};
  std::size_t i = 0;
  for (int p = 0; p < m.patterns; ++p) {
    const Image image(&m.value[static_cast<std::size_t>(p) * face.cells()], face);
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u, ++i) {
        const double value = m.value[i];
        const std::array<double, 3> error{
            interpolated(image, u, v, pitch, offset_u, offset_v) / value - 1.0,
            image(u + shift[0], v + shift[1]) / value - 1.0, std::log(value / largest)};
        for (std::size_t k = 0; k < parts.size(); ++k) {
          parts[k].push_back(error[k]);
          squares[k] += error[k] * error[k];
        }
      }
    }
  }
  std::vector<double> sum(parts[0].size(), 0.0);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (std::size_t j = 0; j < sum.size(); ++j) {
      sum[j] += share[k] * parts[k][j] / std::sqrt(squares[k]);
    }
  }
  add(m, sum, size);
}

void add_correlated_error(SurfaceMeasurements& m, double size, double length, std::uint64_t seed) {
  Noise chance(seed);
  const FaceShape face = m.seen_shape();
  const int reach = static_cast<int>(std::ceil(3.0 * length));
  std::vector<double> errors;
  for (int p = 0; p < m.patterns; ++p) {
    const int across = face.nu + 2 * reach;
    std::vector<double> white(static_cast<std::size_t>(across) *
                              static_cast<std::size_t>(face.nv + 2 * reach));
    for (double& x : white) x = chance.normal();
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        double sum = 0.0;
        for (int dv = -reach; dv <= reach; ++dv) {
          for (int du = -reach; du <= reach; ++du) {
            sum += std::exp(-(du * du + dv * dv) / (length * length)) *
                   white[static_cast<std::size_t>((v + reach + dv) * across + u + reach + du)];
          }
        }
        errors.push_back(sum);
      }
    }
  }
  add(m, errors, size);
}

}  // namespace kappamu::test_cases
