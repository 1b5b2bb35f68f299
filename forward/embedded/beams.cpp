#include "forward/embedded/beams.h"

#include <algorithm>
#include <cmath>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/light_entry.h"

namespace kappamu::forward::embedded {

namespace {

/// When no more than this share of a beam is left, the rest collides in the cube that it has
/// reached.
constexpr double negligible = 1e-9;

/// Mean of each shape function over a chord of the unit cube along which light fades by e^−depth.
std::array<double, 8> along_chord(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                  double depth) {
  // Gauss points in the share of the light that has collided, uniform on [0, 1].
  constexpr std::array<double, 4> node{0.0694318442029737, 0.3300094782075719, 0.6699905217924281,
                                       0.9305681557970263};
  constexpr std::array<double, 4> weight{0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                         0.1739274225687269};
  std::array<double, 8> mean{};
  for (std::size_t g = 0; g < node.size(); ++g) {
    const double at = depth < 1e-6 ? node[g] : -std::log1p(node[g] * std::expm1(-depth)) / depth;
    const std::array<double, 8> n = shape_functions(from + at * (to - from));
    for (std::size_t i = 0; i < 8; ++i) mean[i] += weight[g] * n[i];
  }
  return mean;
}

class March {
 public:
  March(const Octree& tree, const CutMesh& mesh, const NodeSpace& space,
        const std::vector<Coefficients>& coefficients)
      : tree_(tree), mesh_(mesh), space_(space), coefficients_(coefficients) {}

  /// From a point of the object along a unit direction for a length [mm].
  void run(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double length,
           double power, BeamPowers& powers, std::vector<double>& load) const {
    const double step_over = 1e-12;  // of the root, into the next cube
    const Eigen::Vector3d start = tree_.to_root(from);
    const double end = length / tree_.edge_mm();
    const double least = negligible * power;
    double at = 0.0;
    while (at < end && power > 0.0) {
      const int leaf = tree_.leaf_at(start + (at + step_over) * direction);
      const Cube& cube = tree_.cube(leaf);
      const double next =
          std::min(end, std::max(leaves_at(cube, start, direction), at + step_over));
      const int k = mesh_.cube_of_leaf[static_cast<std::size_t>(leaf)];
      if (k >= 0) {
        const auto index = static_cast<std::size_t>(k);
        const double sigma_t = 1.0 / (3.0 * coefficients_[index].kappa);
        const double depth = sigma_t * (next - at) * tree_.edge_mm();
        const double fades_to = power * std::exp(-depth);
        const double collided = fades_to > least ? power - fades_to : power;
        const double absorbed = collided * std::min(1.0, coefficients_[index].mu / sigma_t);
        const Eigen::Vector3d corner(cube.at[0], cube.at[1], cube.at[2]);
        const double scale = std::ldexp(1.0, cube.level);
        std::array<double, 8> share =
            along_chord(scale * (start + at * direction) - corner,
                        scale * (start + next * direction) - corner, depth);
        for (double& s : share) s *= collided - absorbed;
        add_load(space_, index, share, load);
        powers.absorbed += absorbed;
        powers.scattered += collided - absorbed;
        power -= collided;
      }
      at = next;
    }
    powers.unscattered += power;
  }

 private:
  /// Where the ray leaves the cube.
  static double leaves_at(const Cube& cube, const Eigen::Vector3d& start,
                          const Eigen::Vector3d& direction) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] == 0.0) continue;
      const double plane =
          std::ldexp(cube.at[static_cast<std::size_t>(axis)] + (direction[axis] > 0.0 ? 1.0 : 0.0),
                     -cube.level);
      nearest = std::min(nearest, (plane - start[axis]) / direction[axis]);
    }
    return nearest;
  }

  const Octree& tree_;
  const CutMesh& mesh_;
  const NodeSpace& space_;
  const std::vector<Coefficients>& coefficients_;
};

}  // namespace

std::vector<Chord> chords_of(const ObjectProblem& problem, const std::vector<Beam>& beams) {
  std::vector<Chord> chords(beams.size());
  const double size = bounding_box(problem.mesh).sizes().maxCoeff();
  for_row_ranges(beams.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Beam unit = beams[k];
      unit.power = 1.0;
      const BeamPath path = enter(problem, unit, size);
      chords[k] = {path.from, path.direction, path.length, path.power};
    }
  });
  return chords;
}

BeamPowers add_beams(const Octree& tree, const CutMesh& mesh, const NodeSpace& space,
                     const std::vector<Coefficients>& coefficients, const std::vector<Beam>& beams,
                     const std::vector<Chord>& chords, std::vector<double>& load) {
  const March march(tree, mesh, space, coefficients);
  // A fixed number of parts, each with its own load: the same bits on any number of cores.
  constexpr std::size_t parts = 4;
  std::vector<BeamPowers> powers(parts);
  std::vector<std::vector<double>> loads(beams.empty() ? 0 : parts);
  for_rows(static_cast<int>(loads.size()), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    loads[part].assign(load.size(), 0.0);
    for (std::size_t k = part * beams.size() / parts; k < (part + 1) * beams.size() / parts; ++k) {
      const double power = beams[k].power * chords[k].transmitted;
      powers[part].entering += power;
      march.run(chords[k].from, chords[k].direction, chords[k].length, power, powers[part],
                loads[part]);
    }
  });
  BeamPowers total;
  for (std::size_t part = 0; part < loads.size(); ++part) {
    total.entering += powers[part].entering;
    total.scattered += powers[part].scattered;
    total.absorbed += powers[part].absorbed;
    total.unscattered += powers[part].unscattered;
    for (std::size_t u = 0; u < load.size(); ++u) load[u] += loads[part][u];
  }
  return total;
}

}  // namespace kappamu::forward::embedded
