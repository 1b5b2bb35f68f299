#include "core/numbers/noise.h"

#include <array>
#include <cmath>

#include "core/random.h"

namespace kappamu {

namespace {

double lattice(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  return 2.0 * uniform(key_of({seed, static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y),
                               static_cast<std::uint64_t>(z)})) -
         1.0;
}

double quintic(double t) {
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

double blend(double t, double a, double b) {
  return a + t * (b - a);
}

}  // namespace

double value_noise(const Eigen::Vector3d& position, std::uint64_t seed) {
  std::array<std::int64_t, 3> cell{};
  std::array<double, 3> weight{};
  for (int axis = 0; axis < 3; ++axis) {
    const double below = std::floor(position[axis]);
    cell[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(below);
    weight[static_cast<std::size_t>(axis)] = quintic(position[axis] - below);
  }
  std::array<double, 4> along_x{};
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const std::int64_t y = cell[1] + static_cast<std::int64_t>(corner & 1);
    const std::int64_t z = cell[2] + static_cast<std::int64_t>(corner >> 1);
    along_x[corner] =
        blend(weight[0], lattice(cell[0], y, z, seed), lattice(cell[0] + 1, y, z, seed));
  }
  return blend(weight[2], blend(weight[1], along_x[0], along_x[1]),
               blend(weight[1], along_x[2], along_x[3]));
}

double layered_noise(const Eigen::Vector3d& position, double size, int octaves,
                     std::uint64_t seed) {
  double sum = 0.0;
  double weight = 1.0;
  double total = 0.0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum +=
        weight * value_noise(position / size, key_of({seed, static_cast<std::uint64_t>(octave)}));
    total += weight;
    weight *= 0.5;
    size *= 0.5;
  }
  return sum / total;
}

}  // namespace kappamu
