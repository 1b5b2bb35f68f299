#include "forward/polygrid/beams.h"

#include <algorithm>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

constexpr std::size_t width = BeamWalks::most_channels;
/// Beams are marched in a fixed number of parts, each with its own load: the same bits on any
/// number of cores.
constexpr std::size_t parts = 4;
constexpr std::size_t corners_of_block = 64;
/// Least step in a cell's own coordinates, and the step beyond the outermost cells.
constexpr double least_step = 1e-3, step_outside = 0.5;
constexpr std::size_t most_steps = 100'000;
/// Of all beams: beyond, all are marched anew.
constexpr double most_again = 0.25;

bool same_path(const Beam& a, const Beam& b) {
  return a.triangle == b.triangle && a.position == b.position && a.direction == b.direction;
}

bool same_numbers(const Coefficients& a, const Coefficients& b) {
  return a.kappa == b.kappa && a.mu == b.mu;
}

void add_to(OfChannels& sum, const OfChannels& more) {
  for (std::size_t c = 0; c < width; ++c) sum[c] += more[c];
}

}  // namespace

/// Cells along a chord.
class BeamWalks::Cells {
 public:
  Cells(const Polygrid& grid, int first_cell, bool from_inside, CellRay& ray)
      : grid_(grid), first_cell_(first_cell), from_inside_(from_inside), ray_(ray) {}

  void start(const Chord& chord) {
    from_ = chord.from;
    direction_ = chord.direction;
    walked_ = 0.0;
    // A chord that is not the first begins where the last one ended.
    const CellPoint near =
        first_cell_ >= 0 ? CellPoint{first_cell_, Vector3d::Constant(0.5)} : ray_.at;
    if (first_cell_ >= 0 && from_inside_) return start_inside(chord, near);
    first_cell_ = -1;
    ray_ = ray_at(grid_, near, from_, direction_);
  }

  void resume(const Chord& chord, const PathPlace& place) {
    from_ = chord.from;
    direction_ = chord.direction;
    walked_ = place.walked;
  }

  CellStep step(double most) {
    const CellRay here = ray_;
    const CellExit exit = exit_of(here);
    const int link =
        grid_.link[static_cast<std::size_t>(here.at.cell)][static_cast<std::size_t>(exit.side)];
    const double least = (link >= 0 ? least_step : step_outside) / here.along.cwiseAbs().maxCoeff();
    const double length = std::min(std::max(exit.distance, least), most);
    const Vector3d end = here.at.local + length * here.along;
    walked_ += length;
    CellPoint next{here.at.cell, end};
    if (link >= 0 && length < most) {  // most cells' axes are those of their neighbours
      next.cell = link;
      next.local[exit.side / 2] += exit.side % 2 == 0 ? 1.0 : -1.0;
    }
    next.local = within(next.local);
    if (length < most) {
      ray_ = ray_at(grid_, next, from_ + walked_ * direction_, direction_);
    } else {
      ray_.at = next;
    }
    CellStep step;
    step.cell = here.at.cell;
    step.length = length;
    step.from = within(here.at.local).cast<float>();
    step.along = within(end).cast<float>() - step.from;
    return step;
  }

 private:
  /// The cell that a chord begins in, away from the surface, is found from its end back.
  void start_inside(const Chord& chord, const CellPoint& end) {
    first_cell_ = -1;
    from_ = chord.from + chord.length * chord.direction;
    direction_ = -chord.direction;
    ray_ = ray_at(grid_, end, from_, direction_);
    double most = chord.length;
    while (step(most).length < most) most = chord.length - walked_;
    const CellPoint begin = ray_.at;
    from_ = chord.from;
    direction_ = chord.direction;
    walked_ = 0.0;
    ray_ = ray_at(grid_, begin, from_, direction_);
  }
  static Vector3d within(const Vector3d& local) {
    return local.cwiseMax(Vector3d::Zero()).cwiseMin(Vector3d::Ones());
  }

  const Polygrid& grid_;
  int first_cell_;  ///< −1: the path has begun
  bool from_inside_;
  CellRay& ray_;
  Vector3d from_ = Vector3d::Zero(), direction_ = Vector3d::Zero();  ///< of the chord [mm]
  double walked_ = 0.0;                                              ///< of it [mm]
};

/// Where a beam's march leaves its powers.
class BeamWalks::Marched {
 public:
  Marched(const BeamWalks& walks, const Walls& walls, Walk& walk, double sign, Left& left)
      : walks_(walks), walls_(walls), walk_(walk), sign_(sign), left_(left) {}

  const CellOptics& optics(int cell) const {
    return walks_.optics_[static_cast<std::size_t>(cell)];
  }
  void deposit(int cell, const CornerShares& shares) {
    const std::array<int, 8>& corners = walks_.grid_.cell_corners[static_cast<std::size_t>(cell)];
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto corner = static_cast<std::size_t>(corners[i]);
      for (std::size_t c = 0; c < width; ++c) {
        left_.load[width * corner + c] += sign_ * shares[i][c];
      }
      left_.touched[corner / corners_of_block] = 1;
    }
  }
  void leave(std::size_t k, const OfChannels& power) {
    if (walks_.keep_) return;
    const Chord& chord = *walk_.path->chord(k, walls_);
    for (std::size_t c = 0; c < width; ++c) {
      if (power[c] > 0.0) left_.leaving[c].push_back(leaving(walls_, chord, power[c]));
    }
  }

 private:
  const BeamWalks& walks_;
  const Walls& walls_;
  Walk& walk_;
  double sign_;
  Left& left_;
};

BeamWalks::BeamWalks(const Polygrid& grid, const SurfaceMap& map, Steps steps)
    : grid_(grid), map_(map), keep_(steps == Steps::kept) {}

bool BeamWalks::same(std::span<const ChannelBeams> channels) const {
  return keep_ &&
         std::equal(channels.begin(), channels.end(), beams_.begin(), beams_.end(),
                    [](const ChannelBeams& channel, const std::vector<Beam>& beams) {
                      return std::equal(channel.beams.begin(), channel.beams.end(), beams.begin(),
                                        beams.end(), [](const Beam& a, const Beam& b) {
                                          return same_path(a, b) && a.power == b.power;
                                        });
                    });
}

std::vector<char> BeamWalks::changed_cells(std::span<const ChannelBeams> channels) const {
  std::vector<char> changed(grid_.cell.size(), media_.size() == channels.size() ? 0 : 1);
  if (media_.size() != channels.size()) return changed;
  for_ranges(changed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (std::size_t k = begin; k < end; ++k) {
        if (!same_numbers(channels[c].of_cell[k], media_[c][k])) changed[k] = 1;
      }
    }
  });
  return changed;
}

void BeamWalks::renew_optics(std::span<const ChannelBeams> channels,
                             const std::vector<char>& changed) {
  media_.resize(channels.size());
  optics_.resize(changed.size());
  for (auto& of_cell : media_) of_cell.resize(changed.size());
  for_ranges(changed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (changed[k] == 0) continue;
      for (std::size_t c = 0; c < channels.size(); ++c) {
        media_[c][k] = channels[c].of_cell[k];
        set_lane(media_[c][k], c, optics_[k]);
      }
    }
  });
}

std::vector<const Beam*> BeamWalks::join(std::span<const ChannelBeams> channels) {
  std::vector<const Beam*> of_walk;
  // Channels list their beams in the order of the triangles: the least triangle is next.
  std::vector<std::size_t> next(channels.size(), 0);
  while (true) {
    const Beam* first = nullptr;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      if (next[c] == channels[c].beams.size()) continue;
      const Beam& beam = channels[c].beams[next[c]];
      if (first == nullptr || beam.triangle < first->triangle) first = &beam;
    }
    if (first == nullptr) break;
    if (of_walk.size() == walks_.size()) walks_.emplace_back();
    OfChannels& power = walks_[of_walk.size()].power;
    power.fill(0.0);
    of_walk.push_back(first);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      if (next[c] == channels[c].beams.size()) continue;
      const Beam& beam = channels[c].beams[next[c]];
      if (!same_path(beam, *first)) continue;
      power[c] = beam.power;
      ++next[c];
    }
  }
  walks_.resize(of_walk.size());
  return of_walk;
}

void BeamWalks::enter(const Walls& walls, const Beam& beam, Walk& walk) const {
  if (keep_ && walk.path && same_path(walk.beam, beam)) return;
  walk.path.emplace(walls, beam);
  walk.beam = beam;
  walk.place = {};
  walk.steps.clear();
}

void BeamWalks::follow(const Walls& walls, Walk& walk, double remainder, double sign,
                       Left& left) const {
  const int side = map_.side_of(static_cast<std::size_t>(walk.path->enters()));
  const bool begun = walk.place.chords > 0;
  Cells cells(grid_, begun ? -1 : grid_.boundary_cell[static_cast<std::size_t>(side)],
              walk.path->from_inside(), walk.ray);
  if (walk.place.on_chord)
    cells.resume(*walk.path->chord(walk.place.chords - 1, walls), walk.place);
  BeamLight light = entering(*walk.path, walk.power, remainder);
  std::size_t taken = 0;
  CellStep fresh;
  const auto next = [&]() -> const CellStep* {
    if (taken == most_steps) return nullptr;
    if (taken < walk.steps.size()) return &walk.steps[taken++];
    if (!next_step(*walk.path, walls, walk.place, cells, fresh)) return nullptr;
    ++taken;
    if (keep_) walk.steps.push_back(fresh);
    return &fresh;
  };
  for (std::size_t c = 0; c < width; ++c) left.entering[c] += sign * light.left[c];
  march(next, light, Marched(*this, walls, walk, sign, left));
  for (std::size_t c = 0; c < width; ++c) {
    left.absorbed[c] += sign * light.absorbed[c];
    left.unscattered[c] += sign * light.unscattered[c];
  }
}

void BeamWalks::march_all(const Walls& walls, std::span<const Beam* const> entering,
                          double remainder) {
  const std::size_t corners = grid_.corner.size();
  const std::size_t blocks = (corners + corners_of_block - 1) / corners_of_block;
  std::vector<Left> of_part = std::move(parts_);  // none are kept of beams that throw
  of_part.resize(parts);
  for_rows(static_cast<int>(parts), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    Left& left = of_part[part];
    left.load.resize(corners * width, 0.0);
    left.touched.assign(blocks, 0);
    left.entering = left.absorbed = left.unscattered = OfChannels{};
    left.leaving = {};
    for (std::size_t k = part * walks_.size() / parts; k < (part + 1) * walks_.size() / parts;
         ++k) {
      if (!entering.empty()) enter(walls, *entering[k], walks_[k]);
      follow(walls, walks_[k], remainder, 1.0, left);
    }
  });
  left_.load.resize(corners * width);
  left_.touched.assign(blocks, 0);
  left_.entering = left_.absorbed = left_.unscattered = OfChannels{};
  left_.leaving = {};
  for (const Left& part : of_part) {
    add_to(left_.entering, part.entering);
    add_to(left_.absorbed, part.absorbed);
    add_to(left_.unscattered, part.unscattered);
    for (std::size_t c = 0; c < width; ++c) {
      left_.leaving[c].insert(left_.leaving[c].end(), part.leaving[c].begin(),
                              part.leaving[c].end());
    }
  }
  for_ranges(corners, [&](std::size_t begin, std::size_t end) {
    for (; begin < end; begin += corners_of_block) {
      const std::size_t block = begin / corners_of_block, first = begin * width,
                        last = std::min(end, begin + corners_of_block) * width;
      const auto clear = [&](std::vector<double>& load) {
        std::fill(load.begin() + static_cast<std::ptrdiff_t>(first),
                  load.begin() + static_cast<std::ptrdiff_t>(last), 0.0);
      };
      clear(left_.load);
      for (Left& part : of_part) {
        if (part.touched[block] == 0) continue;
        left_.touched[block] = 1;
        for (std::size_t i = first; i < last; ++i) left_.load[i] += part.load[i];
        clear(part.load);
      }
    }
  });
  parts_ = std::move(of_part);
}

void BeamWalks::add(const ObjectProblem& problem, std::span<const ChannelBeams> channels,
                    double remainder) {
  check(channels.size() <= most_channels, "beams of more channels than are followed together");
  const bool none = std::all_of(channels.begin(), channels.end(),
                                [](const ChannelBeams& channel) { return channel.beams.empty(); });
  if (none && walks_.empty()) return;
  const MeshWalls walls(problem);
  const std::vector<char> changed = changed_cells(channels);
  if (same(channels)) {
    std::vector<Walk*> affected;
    for (Walk& walk : walks_) {
      if (std::any_of(walk.steps.begin(), walk.steps.end(), [&](const CellStep& step) {
            return changed[static_cast<std::size_t>(step.cell)] != 0;
          })) {
        affected.push_back(&walk);
      }
    }
    const bool few =
        static_cast<double>(affected.size()) <= most_again * static_cast<double>(walks_.size());
    for (Walk* walk : affected) {
      if (few) follow(walls, *walk, remainder, -1.0, left_);
    }
    renew_optics(channels, changed);
    if (!few) march_all(walls, {}, remainder);
    for (Walk* walk : affected) {
      if (few) follow(walls, *walk, remainder, 1.0, left_);
    }
  } else {
    beams_.clear();
    const std::vector<const Beam*> entering = join(channels);
    renew_optics(channels, changed);
    march_all(walls, entering, remainder);
    for (const ChannelBeams& channel : channels) {
      if (keep_) beams_.emplace_back(channel.beams.begin(), channel.beams.end());
    }
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    channels[c].balance.entering += left_.entering[c];
    channels[c].balance.absorbed += left_.absorbed[c];
    channels[c].balance.unscattered += left_.unscattered[c];
    if (channels[c].leaving != nullptr) *channels[c].leaving = left_.leaving[c];
  }
  for_ranges(grid_.corner.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (left_.touched[i / corners_of_block] == 0) continue;
      for (std::size_t c = 0; c < channels.size(); ++c) {
        channels[c].load[i] += left_.load[i * width + c];
      }
    }
  });
}

}  // namespace kappamu::forward::polygrid
