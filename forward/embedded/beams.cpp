#include "forward/embedded/beams.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "core/parallel.h"

namespace kappamu::forward::embedded {

namespace {

/// When no more than this share of a beam is left, the rest collides in the cube that it has
/// reached: as much as the linear systems leave open.
constexpr double negligible = 1e-6;

/// Cubes along a chord.
class Cubes {
 public:
  Cubes(const Octree& tree, const CutMesh& mesh) : tree_(tree), mesh_(mesh) {}

  void start(const Chord& chord) {
    start_ = tree_.to_root(chord.from);
    direction_ = chord.direction;
    at_ = 0.0;
  }

  CellStep step(double most) {
    constexpr double step_over = 1e-12;  // of the root, into the next cube
    leaf_ = tree_.leaf_at(start_ + (at_ + step_over) * direction_, leaf_);
    const Cube& cube = tree_.cube(leaf_);
    const double length =
        std::min(most, std::max(leaves_at(cube) - at_, step_over) * tree_.edge_mm());
    const double count = std::ldexp(1.0, cube.level);
    CellStep step;
    step.cell = mesh_.cube_of_leaf[static_cast<std::size_t>(leaf_)];
    step.length = length;
    step.from =
        ((start_ + at_ * direction_) * count - Eigen::Vector3d(cube.at[0], cube.at[1], cube.at[2]))
            .cast<float>();
    step.along = (length / tree_.edge_mm() * count * direction_).cast<float>();
    at_ += length / tree_.edge_mm();
    return step;
  }

 private:
  double leaves_at(const Cube& cube) const {
    const double edge = std::ldexp(1.0, -cube.level);
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double along = direction_[axis];
      if (along == 0.0) continue;
      const double plane =
          edge * (cube.at[static_cast<std::size_t>(axis)] + (along > 0.0 ? 1.0 : 0.0));
      nearest = std::min(nearest, (plane - start_[axis]) / along);
    }
    return nearest;
  }

  const Octree& tree_;
  const CutMesh& mesh_;
  Eigen::Vector3d start_ = Eigen::Vector3d::Zero();      ///< of the chord, in the root
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  ///< its own
  double at_ = 0.0;                                      ///< of the root's edge
  int leaf_ = 0;
};

/// What beams that run alike leave, one of every channel.
class Loads {
 public:
  Loads(const std::vector<CellOptics>& optics, const NodeSpace& space, BeamPaths& paths,
        std::span<const ChannelBeams> channels)
      : optics_(optics),
        space_(space),
        paths_(paths),
        channels_(channels),
        balance_(channels.size()),
        leaving_(channels.size()),
        load_(beam_lanes * space.unknowns(), 0.0) {}

  void run(const Octree& tree, const CutMesh& mesh, std::size_t beam) {
    path_ = &paths_.path[beam];
    OfChannels power{};
    for (std::size_t c = 0; c < channels_.size(); ++c) power[c] = (*channels_[c].beams)[beam].power;
    BeamLight light = entering(*path_, power, negligible);
    for (std::size_t c = 0; c < channels_.size(); ++c) balance_[c].entering += light.left[c];
    Cubes cubes(tree, mesh);
    PathPlace place;
    CellStep step;
    march([&] { return next_step(*path_, paths_.walls, place, cubes, step) ? &step : nullptr; },
          light, *this);
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      balance_[c].absorbed += light.absorbed[c];
      balance_[c].unscattered += light.unscattered[c];
    }
  }
  const CellOptics& optics(int cube) const { return optics_[static_cast<std::size_t>(cube)]; }
  void deposit(int cube, const CornerShares& shares) {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const auto parts = space_.parts(static_cast<std::size_t>(cube), i);
      const double weight = NodeSpace::weight(parts);
      for (const int u : parts) {
        double* to = load_.data() + static_cast<std::size_t>(u) * beam_lanes;
        for (std::size_t c = 0; c < beam_lanes; ++c) to[c] += weight * shares[i][c];
      }
    }
  }
  void leave(std::size_t k, const OfChannels& power) {
    const Chord& chord = *path_->chord(k, paths_.walls);
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      if (power[c] > 0.0) leaving_[c].push_back(leaving(paths_.walls, chord, power[c]));
    }
  }

  /// Adds all but the loads.
  void add_powers() const {
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      channels_[c].balance->entering += balance_[c].entering;
      channels_[c].balance->absorbed += balance_[c].absorbed;
      channels_[c].balance->unscattered += balance_[c].unscattered;
      channels_[c].leaving->insert(channels_[c].leaving->end(), leaving_[c].begin(),
                                   leaving_[c].end());
    }
  }
  void add_loads(std::size_t begin, std::size_t end) const {
    for (std::size_t u = begin; u < end; ++u) {
      for (std::size_t c = 0; c < channels_.size(); ++c) {
        (*channels_[c].load)[u] += load_[u * beam_lanes + c];
      }
    }
  }

 private:
  const std::vector<CellOptics>& optics_;
  const NodeSpace& space_;
  BeamPaths& paths_;
  BeamPath* path_ = nullptr;  ///< that is marched
  std::span<const ChannelBeams> channels_;
  std::vector<ObjectBalance> balance_;
  std::vector<std::vector<Beam>> leaving_;
  std::vector<double> load_;  ///< [unknown][lane]
};

/// Up to beam_lanes channels.
void add_lanes(const Octree& tree, const CutMesh& mesh, const NodeSpace& space, BeamPaths& paths,
               std::span<const ChannelBeams> channels) {
  std::vector<CellOptics> optics(mesh.cubes.size());
  for_ranges(optics.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      for (std::size_t c = 0; c < channels.size(); ++c) {
        set_lane((*channels[c].coefficients)[k], c, optics[k]);
      }
    }
  });
  // A fixed number of parts, each with its own loads: the same bits on any number of cores.
  constexpr std::size_t parts = 4;
  const std::size_t beams = paths.path.size();
  std::vector<std::optional<Loads>> loads(beams == 0 ? 0 : parts);
  for_rows(static_cast<int>(loads.size()), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    loads[part].emplace(optics, space, paths, channels);
    for (std::size_t k = part * beams / parts; k < (part + 1) * beams / parts; ++k) {
      loads[part]->run(tree, mesh, k);
    }
  });
  for (const std::optional<Loads>& part : loads) part->add_powers();
  for_ranges(space.unknowns(), [&](std::size_t begin, std::size_t end) {
    for (const std::optional<Loads>& part : loads) part->add_loads(begin, end);
  });
}

}  // namespace

BeamPaths::BeamPaths(const Walls& its_walls, const std::vector<Beam>& beams) : walls(its_walls) {
  constexpr std::size_t piece = 1024;
  std::vector<std::vector<BeamPath>> of_piece((beams.size() + piece - 1) / piece);
  for_rows(static_cast<int>(of_piece.size()), [&](int row) {
    const auto p = static_cast<std::size_t>(row);
    for (std::size_t k = p * piece; k < std::min(beams.size(), (p + 1) * piece); ++k) {
      of_piece[p].emplace_back(walls, beams[k]);
    }
  });
  path.reserve(beams.size());
  for (std::vector<BeamPath>& some : of_piece) {
    path.insert(path.end(), std::make_move_iterator(some.begin()),
                std::make_move_iterator(some.end()));
  }
}

void add_beams(const Octree& tree, const CutMesh& mesh, const NodeSpace& space, BeamPaths& paths,
               std::span<const ChannelBeams> channels) {
  for (std::size_t c = 0; c < channels.size(); c += beam_lanes) {
    add_lanes(tree, mesh, space, paths,
              channels.subspan(c, std::min(beam_lanes, channels.size() - c)));
  }
}

}  // namespace kappamu::forward::embedded
