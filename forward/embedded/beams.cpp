#include "forward/embedded/beams.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/light_entry.h"

namespace kappamu::forward::embedded {

namespace {

/// When no more than this share of a beam is left, the rest collides in the cube that it has
/// reached: as much as the linear systems leave open.
constexpr double negligible = 1e-6;

/// Below this depth the powers of `Fading` come from their series, above from one another.
constexpr double shallow = 0.25;

/// What collides along a chord that light fades along by e^−depth, and where.
struct Fading {
  double collided;  ///< 1 − e^−depth
  std::array<double, 4>
      moment;  ///< means over what collides of t^0 to t^3, 0 ≤ t ≤ 1 the way along

  explicit Fading(double depth) {
    // J_k = ∫ t^k e^(−depth t) dt; by parts depth J_k = k J_(k−1) − e^−depth. Where the depth is
    // small, downwards from J_3 = e^−depth Σ_n depth^n 3!/(n+4)!.
    const double left = std::exp(-depth);
    std::array<double, 4> j;
    if (depth < shallow) {
      double series = 1.0;
      for (const double part : {1.0 / 11, 1.0 / 10, 1.0 / 9, 1.0 / 8, 1.0 / 7, 1.0 / 6, 1.0 / 5}) {
        series = 1.0 + depth * part * series;
      }
      j[3] = 0.25 * left * series;
      j[2] = (depth * j[3] + left) * (1.0 / 3.0);
      j[1] = (depth * j[2] + left) * 0.5;
      j[0] = depth * j[1] + left;
      collided = depth * j[0];
    } else {
      collided = 1.0 - left;
      const double inverse = 1.0 / depth;
      j[0] = collided * inverse;
      for (std::size_t k = 1; k < 4; ++k) {
        j[k] = (static_cast<double>(k) * j[k - 1] - left) * inverse;
      }
    }
    const double scale = 1.0 / j[0];
    for (std::size_t k = 0; k < 4; ++k) moment[k] = j[k] * scale;
  }
};

/// `power` shared among the corners by the mean of their shape functions over what collides along a
/// chord of the unit cube.
std::array<double, 8> along_chord(const Eigen::Vector3d& from, const Eigen::Vector3d& way,
                                  const std::array<double, 4>& moment, double power) {
  // Means of x, y, z and their products, all polynomials in t.
  const auto pair = [&](Eigen::Index i, Eigen::Index j) {
    return from[i] * from[j] + moment[1] * (from[i] * way[j] + from[j] * way[i]) +
           moment[2] * way[i] * way[j];
  };
  const double x = from.x() + moment[1] * way.x(), y = from.y() + moment[1] * way.y(),
               z = from.z() + moment[1] * way.z();
  const double xy = pair(0, 1), yz = pair(1, 2), zx = pair(2, 0);
  const double here = from.x() * from.y(), turned = from.x() * way.y() + from.y() * way.x(),
               along = way.x() * way.y();
  const double xyz = here * from.z() + moment[1] * (here * way.z() + turned * from.z()) +
                     moment[2] * (turned * way.z() + along * from.z()) +
                     moment[3] * along * way.z();
  return {power * (1.0 - x - y - z + xy + yz + zx - xyz),
          power * (x - xy - zx + xyz),
          power * (y - xy - yz + xyz),
          power * (xy - xyz),
          power * (z - yz - zx + xyz),
          power * (zx - xyz),
          power * (yz - xyz),
          power * xyz};
}

/// Marches beams that run alike, one of every channel, with loads and powers of its own.
class March {
 public:
  March(const Octree& tree, const CutMesh& mesh, const NodeSpace& space,
        std::span<const ChannelBeams> channels)
      : tree_(tree),
        mesh_(mesh),
        space_(space),
        channels_(channels),
        power_(channels.size()),
        least_(channels.size()),
        share_(channels.size()),
        powers_(channels.size()),
        load_(channels.size() * space.unknowns(), 0.0) {}

  const BeamPowers& powers(std::size_t channel) const { return powers_[channel]; }
  double load(std::size_t channel, std::size_t unknown) const {
    return load_[unknown * channels_.size() + channel];
  }

  /// The beams number `beam`.
  void run(const Chord& chord, std::size_t beam) {
    bool any = false;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      power_[c] = (*channels_[c].beams)[beam].power * chord.transmitted;
      least_[c] = negligible * power_[c];
      powers_[c].entering += power_[c];
      any = any || power_[c] > 0.0;
    }
    const double step_over = 1e-12;  // of the root, into the next cube
    const Eigen::Vector3d start = tree_.to_root(chord.from);
    const Eigen::Vector3d inverse = chord.direction.cwiseInverse();
    const double end = chord.length / tree_.edge_mm();
    double at = 0.0;
    int leaf = 0;
    while (any && at < end) {
      leaf = tree_.leaf_at(start + (at + step_over) * chord.direction, leaf);
      const Cube& cube = tree_.cube(leaf);
      const double edge = std::ldexp(1.0, -cube.level);
      const double next =
          std::min(end, std::max(leaves_at(cube, edge, start, inverse), at + step_over));
      const int k = mesh_.cube_of_leaf[static_cast<std::size_t>(leaf)];
      if (k >= 0) {
        const Eigen::Vector3d corner(cube.at[0], cube.at[1], cube.at[2]);
        const double count = std::ldexp(1.0, cube.level);
        any = collide(static_cast<std::size_t>(k), (start + at * chord.direction) * count - corner,
                      (next - at) * count * chord.direction, (next - at) * tree_.edge_mm());
      }
      at = next;
    }
    for (std::size_t c = 0; c < channels_.size(); ++c) powers_[c].unscattered += power_[c];
  }

 private:
  /// In one cube; whether anything is left.
  bool collide(std::size_t cube, const Eigen::Vector3d& from, const Eigen::Vector3d& way,
               double length_mm) {
    bool any = false;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      share_[c].fill(0.0);
      if (power_[c] <= 0.0) continue;
      const Coefficients& here = (*channels_[c].coefficients)[cube];
      const double sigma_t = 1.0 / (3.0 * here.kappa);
      const Fading fading(sigma_t * length_mm);
      double collided = power_[c] * fading.collided;
      if (power_[c] - collided <= least_[c]) collided = power_[c];
      const double absorbed = collided * std::min(1.0, 3.0 * here.kappa * here.mu);
      share_[c] = along_chord(from, way, fading.moment, collided - absorbed);
      powers_[c].absorbed += absorbed;
      powers_[c].scattered += collided - absorbed;
      power_[c] -= collided;
      any = any || power_[c] > 0.0;
    }
    for (std::size_t i = 0; i < 8; ++i) {
      const auto parts = space_.parts(cube, i);
      const double weight = NodeSpace::weight(parts);
      for (const int u : parts) {
        double* to = load_.data() + static_cast<std::size_t>(u) * channels_.size();
        for (std::size_t c = 0; c < channels_.size(); ++c) to[c] += weight * share_[c][i];
      }
    }
    return any;
  }

  /// Where the ray leaves the cube; `inverse` of its direction.
  static double leaves_at(const Cube& cube, double edge, const Eigen::Vector3d& start,
                          const Eigen::Vector3d& inverse) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(inverse[axis])) continue;
      const double plane =
          edge * (cube.at[static_cast<std::size_t>(axis)] + (inverse[axis] > 0.0 ? 1.0 : 0.0));
      nearest = std::min(nearest, (plane - start[axis]) * inverse[axis]);
    }
    return nearest;
  }

  const Octree& tree_;
  const CutMesh& mesh_;
  const NodeSpace& space_;
  std::span<const ChannelBeams> channels_;
  std::vector<double> power_, least_;         ///< of each channel's beam
  std::vector<std::array<double, 8>> share_;  ///< of each channel, of a cube's corners
  std::vector<BeamPowers> powers_;
  std::vector<double> load_;  ///< [unknown][channel]
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

std::vector<BeamPowers> add_beams(const Octree& tree, const CutMesh& mesh, const NodeSpace& space,
                                  const std::vector<Chord>& chords,
                                  std::span<const ChannelBeams> channels) {
  // A fixed number of parts, each with its own loads: the same bits on any number of cores.
  constexpr std::size_t parts = 4;
  std::vector<std::optional<March>> marches(chords.empty() ? 0 : parts);
  for_rows(static_cast<int>(marches.size()), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    marches[part].emplace(tree, mesh, space, channels);
    for (std::size_t k = part * chords.size() / parts; k < (part + 1) * chords.size() / parts;
         ++k) {
      marches[part]->run(chords[k], k);
    }
  });
  std::vector<BeamPowers> total(channels.size());
  for (const std::optional<March>& march : marches) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const BeamPowers& part = march->powers(c);
      total[c].entering += part.entering;
      total[c].scattered += part.scattered;
      total[c].absorbed += part.absorbed;
      total[c].unscattered += part.unscattered;
    }
  }
  for_row_ranges(space.unknowns(), [&](std::size_t begin, std::size_t end) {
    for (const std::optional<March>& march : marches) {
      for (std::size_t u = begin; u < end; ++u) {
        for (std::size_t c = 0; c < channels.size(); ++c) {
          (*channels[c].load)[u] += march->load(c, u);
        }
      }
    }
  });
  return total;
}

}  // namespace kappamu::forward::embedded
