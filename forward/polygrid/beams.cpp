#include "forward/polygrid/beams.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/error.h"
#include "core/numbers/widest.h"
#include "core/parallel.h"
#include "forward/embedded/equations/row_ranges.h"
#include "forward/light_entry.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;
using OfChannels = BeamWalks::OfChannels;

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

typedef double Lanes __attribute__((vector_size(width * sizeof(double))));  // NOLINT

/// A beam's powers on its way, after `remainder` of which the rest collides at once.
struct Power {
  Lanes left, remainder, absorbed;
};

/// What collides in a step, added to the load of the cell's corners. False: nothing is left.
KAPPAMU_WIDEST bool collide(const BeamWalks::Step& step, const BeamWalks::CellOptics& optics,
                            const std::array<int, 8>& corners, double sign, Power& power,
                            double* load) {
  Lanes depth, scattering;
  std::memcpy(&depth, optics.sigma_t.data(), sizeof depth);
  std::memcpy(&scattering, optics.scattered.data(), sizeof scattering);
  const auto length = static_cast<double>(step.length);
  constexpr double deepest = 700.0;  // e^-700 is a number yet
  depth *= length;
  depth = depth < deepest ? depth : Lanes{} + deepest;
  // e^(−depth) = 2^(−k) e^(−r), e^(−r) − 1 by its series. `shift` leaves k in the last bits.
  constexpr double per_ln2 = 1.4426950408889634, shift = 6755399441055744.0;
  constexpr double ln2_high = 0.6931471803691238, ln2_low = 1.9082149292705877e-10;
  const Lanes shifted = depth * per_ln2 + shift, k = shifted - shift;
  const Lanes r = (depth - k * ln2_high) - k * ln2_low;
  typedef long long Bits __attribute__((vector_size(sizeof(Lanes))));  // NOLINT
  Bits bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  bits = (1023 - (bits & 0xffff)) << 52;
  Lanes halved;
  std::memcpy(&halved, &bits, sizeof halved);
  Lanes series{};
  double of_term = 1.0;  // n!/11!
  for (int n = 11; n > 0; --n) {
    series = of_term - series * r;
    of_term *= n;
  }
  series *= r * (-1.0 / of_term);
  const Lanes rest = halved + halved * series, share = (1.0 - halved) - halved * series;
  // ∫ s e^(−σ s) ds over ∫ e^(−σ s) ds from the middle, by its series where the step is thin.
  constexpr double thin = 1e-3;
  const Lanes off =
      length * (depth < thin ? depth * (-1.0 / 12.0) : 1.0 / depth - rest / share - 0.5);
  const Lanes collided = power.left * rest > power.remainder ? power.left * share : power.left;
  const Lanes scattered = collided * scattering;
  power.left -= collided;
  power.absorbed += collided - scattered;
  Lanes at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = static_cast<double>(step.at[a]) + off * static_cast<double>(step.along[a]);
    at[a] = at[a] > 0.0 ? at[a] : Lanes{};
    at[a] = at[a] < 1.0 ? at[a] : Lanes{} + 1.0;
  }
  const Lanes sent = sign * scattered;
  for (std::size_t i = 0; i < 8; ++i) {
    const Lanes share_of =
        ((i & 1) != 0 ? at[0] : 1.0 - at[0]) *
        (((i & 2) != 0 ? at[1] : 1.0 - at[1]) * (sent * ((i & 4) != 0 ? at[2] : 1.0 - at[2])));
    double* to = load + width * static_cast<std::size_t>(corners[i]);
    Lanes sum;
    std::memcpy(&sum, to, sizeof sum);
    sum += share_of;
    std::memcpy(to, &sum, sizeof sum);
  }
  return power.left[0] + power.left[1] + power.left[2] + power.left[3] > 0.0;
}

void add_to(OfChannels& sum, const OfChannels& more) {
  for (std::size_t c = 0; c < width; ++c) sum[c] += more[c];
}

}  // namespace

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
  embedded::for_row_ranges(changed.size(), [&](std::size_t begin, std::size_t end) {
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
  embedded::for_row_ranges(changed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (changed[k] == 0) continue;
      for (std::size_t c = 0; c < channels.size(); ++c) {
        const auto [kappa, mu] = media_[c][k] = channels[c].of_cell[k];
        optics_[k].sigma_t[c] = 1.0 / (3.0 * kappa);
        optics_[k].scattered[c] = 1.0 - std::min(1.0, 3.0 * kappa * mu);
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

void BeamWalks::enter(const ObjectProblem& problem, double size, Beam beam, Walk& walk) const {
  beam.power = 1.0;
  const BeamPath path = forward::enter(problem, beam, size);
  for (double& power : walk.power) power *= path.power;
  const int side = map_.side_of(static_cast<std::size_t>(beam.triangle));
  const CellPoint outermost{grid_.boundary_cell[static_cast<std::size_t>(side)],
                            Vector3d::Constant(0.5)};
  walk.steps.clear();
  walk.walked = 0.0;
  walk.from = path.from;
  walk.direction = path.direction;
  walk.length = path.length;
  walk.ray = ray_at(grid_, outermost, path.from, path.direction);
}

BeamWalks::Step BeamWalks::next_step(Walk& walk) const {
  const CellRay here = walk.ray;
  const CellExit exit = exit_of(here);
  const int link =
      grid_.link[static_cast<std::size_t>(here.at.cell)][static_cast<std::size_t>(exit.side)];
  const double least = (link >= 0 ? least_step : step_outside) / here.along.cwiseAbs().maxCoeff();
  const double length = std::min(std::max(exit.distance, least), walk.length - walk.walked);
  walk.walked += length;
  if (walk.walked < walk.length) {
    CellPoint next{here.at.cell, here.at.local + length * here.along};
    if (link >= 0) {  // most cells' axes are those of their neighbours
      next.cell = link;
      next.local[exit.side / 2] += exit.side % 2 == 0 ? 1.0 : -1.0;
    }
    next.local = next.local.cwiseMax(Vector3d::Zero()).cwiseMin(Vector3d::Ones());
    walk.ray = ray_at(grid_, next, walk.from + walk.walked * walk.direction, walk.direction);
  }
  return {here.at.cell, static_cast<float>(length),
          (here.at.local + 0.5 * length * here.along).cast<float>(), here.along.cast<float>()};
}

void BeamWalks::march(Walk& walk, double remainder, double sign, Left& left) const {
  Power power{};
  std::memcpy(&power.left, walk.power.data(), sizeof power.left);
  power.remainder = remainder * power.left;
  bool any = true;
  for (std::size_t k = 0; k < most_steps && any; ++k) {
    const bool known = k < walk.steps.size();
    if (!known && !(walk.walked < walk.length)) break;
    const Step step = known ? walk.steps[k] : next_step(walk);
    if (keep_ && !known) walk.steps.push_back(step);
    const auto cell = static_cast<std::size_t>(step.cell);
    const std::array<int, 8>& corners = grid_.cell_corners[cell];
    any = collide(step, optics_[cell], corners, sign, power, left.load.data());
    for (const int corner : corners) {
      left.touched[static_cast<std::size_t>(corner) / corners_of_block] = 1;
    }
  }
  for (std::size_t c = 0; c < width; ++c) {
    left.absorbed[c] += sign * power.absorbed[c];
    left.unscattered[c] += sign * power.left[c];
  }
}

void BeamWalks::march_all(const ObjectProblem& problem, std::span<const Beam* const> entering,
                          double remainder) {
  const std::size_t corners = grid_.corner.size();
  const std::size_t blocks = (corners + corners_of_block - 1) / corners_of_block;
  const double size = bounding_box(problem.mesh).sizes().maxCoeff();
  std::vector<Left> of_part = std::move(parts_);  // none are kept of beams that throw
  of_part.resize(parts);
  for_rows(static_cast<int>(parts), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    Left& left = of_part[part];
    left.load.resize(corners * width, 0.0);
    left.touched.assign(blocks, 0);
    left.entering = left.absorbed = left.unscattered = OfChannels{};
    for (std::size_t k = part * walks_.size() / parts; k < (part + 1) * walks_.size() / parts;
         ++k) {
      if (!entering.empty()) enter(problem, size, *entering[k], walks_[k]);
      add_to(left.entering, walks_[k].power);
      march(walks_[k], remainder, 1.0, left);
    }
  });
  left_.load.resize(corners * width);
  left_.touched.assign(blocks, 0);
  left_.entering = left_.absorbed = left_.unscattered = OfChannels{};
  for (const Left& part : of_part) {
    add_to(left_.entering, part.entering);
    add_to(left_.absorbed, part.absorbed);
    add_to(left_.unscattered, part.unscattered);
  }
  embedded::for_row_ranges(corners, [&](std::size_t begin, std::size_t end) {
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
  const std::vector<char> changed = changed_cells(channels);
  if (same(channels)) {
    std::vector<Walk*> affected;
    for (Walk& walk : walks_) {
      if (std::any_of(walk.steps.begin(), walk.steps.end(), [&](const Step& step) {
            return changed[static_cast<std::size_t>(step.cell)] != 0;
          })) {
        affected.push_back(&walk);
      }
    }
    const bool few =
        static_cast<double>(affected.size()) <= most_again * static_cast<double>(walks_.size());
    for (Walk* walk : affected) {
      if (few) march(*walk, remainder, -1.0, left_);
    }
    renew_optics(channels, changed);
    if (!few) march_all(problem, {}, remainder);
    for (Walk* walk : affected) {
      if (few) march(*walk, remainder, 1.0, left_);
    }
  } else {
    beams_.clear();
    const std::vector<const Beam*> entering = join(channels);
    renew_optics(channels, changed);
    march_all(problem, entering, remainder);
    for (const ChannelBeams& channel : channels) {
      if (keep_) beams_.emplace_back(channel.beams.begin(), channel.beams.end());
    }
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    channels[c].balance.entering += left_.entering[c];
    channels[c].balance.absorbed += left_.absorbed[c];
    channels[c].balance.unscattered += left_.unscattered[c];
  }
  embedded::for_row_ranges(grid_.corner.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (left_.touched[i / corners_of_block] == 0) continue;
      for (std::size_t c = 0; c < channels.size(); ++c) {
        channels[c].load[i] += left_.load[i * width + c];
      }
    }
  });
}

}  // namespace kappamu::forward::polygrid
