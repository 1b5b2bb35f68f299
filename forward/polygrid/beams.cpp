#include "forward/polygrid/beams.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "forward/embedded/equations/row_ranges.h"
#include "forward/light_entry.h"
#include "forward/polygrid/equations/cell_integrals.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

/// Beams are marched in a fixed number of parts, each with its own load: the same bits on any
/// number of cores.
constexpr std::size_t parts = 4;
/// Least step in a cell's own coordinates, and the step beyond the outermost cells.
constexpr double least_step = 1e-3, step_outside = 0.5;
constexpr std::size_t most_steps = 100'000;
/// Of all beams: beyond, all are marched anew.
constexpr double most_again = 0.25;

bool same_path(const Beam& a, const Beam& b) {
  return a.triangle == b.triangle && a.position == b.position && a.direction == b.direction;
}

/// What collides in a step, and where along it.
struct Collision {
  double share = 0.0, mean = 0.0;  ///< of the power; from the step's begin [mm]
};

Collision collision(double sigma_t, double length) {
  const double depth = sigma_t * length;
  const double share = depth < 1e-2 ? -std::expm1(-depth) : 1.0 - std::exp(-depth);
  // ∫ s e^(−σ s) ds over ∫ e^(−σ s) ds, by its series where the step is thin.
  return {share, depth < 1e-4 ? 0.5 * length : 1.0 / sigma_t - length * (1.0 - share) / share};
}

}  // namespace

BeamWalks::BeamWalks(const Polygrid& grid, const SurfaceMap& map, bool keep)
    : grid_(grid), map_(map), keep_(keep) {}

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

void BeamWalks::enter_all(const ObjectProblem& problem, std::span<const ChannelBeams> channels) {
  power_.clear();
  beams_.clear();
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
    of_walk.push_back(first);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const bool has =
          next[c] < channels[c].beams.size() && same_path(channels[c].beams[next[c]], *first);
      power_.push_back(has ? channels[c].beams[next[c]].power : 0.0);
      if (has) ++next[c];
    }
  }
  walks_.resize(of_walk.size());
  const double size = bounding_box(problem.mesh).sizes().maxCoeff();
  embedded::for_row_ranges(walks_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Beam beam = *of_walk[k];
      beam.power = 1.0;
      const BeamPath path = enter(problem, beam, size);
      for (std::size_t c = 0; c < channels.size(); ++c) {
        power_[k * channels.size() + c] *= path.power;
      }
      const int side = map_.side_of(static_cast<std::size_t>(beam.triangle));
      const CellPoint outermost{grid_.boundary_cell[static_cast<std::size_t>(side)],
                                Vector3d::Constant(0.5)};
      walks_[k].steps.clear();
      walks_[k].walked = 0.0;
      walks_[k].from = path.from;
      walks_[k].direction = path.direction;
      walks_[k].length = path.length;
      walks_[k].ray = ray_at(grid_, outermost, path.from, path.direction);
    }
  });
  if (!keep_) return;
  for (const ChannelBeams& channel : channels) {
    beams_.emplace_back(channel.beams.begin(), channel.beams.end());
  }
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

void BeamWalks::march(Walk& walk, const double* power, const OfCell& of_cell, double remainder,
                      double sign, std::vector<double>& load,
                      std::span<ObjectBalance> balance) const {
  const std::size_t count = of_cell.size();
  std::vector<double> left(power, power + count);
  bool any = true;
  for (std::size_t k = 0; k < most_steps && any; ++k) {
    const bool known = k < walk.steps.size();
    if (!known && !(walk.walked < walk.length)) break;
    const Step step = known ? walk.steps[k] : next_step(walk);
    if (keep_ && !known) walk.steps.push_back(step);
    const auto length = static_cast<double>(step.length);
    const auto& corners = grid_.cell_corners[static_cast<std::size_t>(step.cell)];
    any = false;
    for (std::size_t c = 0; c < count; ++c) {
      if (!(left[c] > 0.0)) continue;
      const auto [kappa, mu] = of_cell[c][static_cast<std::size_t>(step.cell)];
      const double sigma_t = 1.0 / (3.0 * kappa);
      const auto [share, mean] = collision(sigma_t, length);
      const double rest = left[c] * (1.0 - share);
      const double collided = rest > remainder * power[c] ? left[c] * share : left[c];
      const double absorbed = collided * std::min(1.0, mu / sigma_t);
      const Vector3d at = (step.at + static_cast<float>(mean - 0.5 * length) * step.along)
                              .cast<double>()
                              .cwiseMax(Vector3d::Zero())
                              .cwiseMin(Vector3d::Ones());
      const std::array<double, 8> n = shape_functions(at);
      const double scattered = sign * (collided - absorbed);
      for (std::size_t i = 0; i < 8; ++i) {
        load[static_cast<std::size_t>(corners[i]) * count + c] += scattered * n[i];
      }
      balance[c].absorbed += sign * absorbed;
      left[c] -= collided;
      any = any || left[c] > 0.0;
    }
  }
  for (std::size_t c = 0; c < count; ++c) balance[c].unscattered += sign * left[c];
}

void BeamWalks::march_all(const OfCell& of_cell, double remainder) {
  const std::size_t count = of_cell.size();
  std::array<std::vector<double>, parts> loads;
  std::array<std::vector<ObjectBalance>, parts> balances;
  for_rows(static_cast<int>(parts), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    loads[part].assign(grid_.corner.size() * count, 0.0);
    balances[part].resize(count);
    for (std::size_t k = part * walks_.size() / parts; k < (part + 1) * walks_.size() / parts;
         ++k) {
      const double* power = &power_[k * count];
      for (std::size_t c = 0; c < count; ++c) balances[part][c].entering += power[c];
      march(walks_[k], power, of_cell, remainder, 1.0, loads[part], balances[part]);
    }
  });
  load_ = std::move(loads[0]);
  balance_ = std::move(balances[0]);
  for (std::size_t part = 1; part < parts; ++part) {
    for (std::size_t i = 0; i < load_.size(); ++i) load_[i] += loads[part][i];
    for (std::size_t c = 0; c < count; ++c) {
      balance_[c].entering += balances[part][c].entering;
      balance_[c].absorbed += balances[part][c].absorbed;
      balance_[c].unscattered += balances[part][c].unscattered;
    }
  }
}

void BeamWalks::march_changed(const OfCell& of_cell, double remainder) {
  std::vector<char> changed(grid_.cell.size(), 0);
  for (std::size_t c = 0; c < of_cell.size(); ++c) {
    for (std::size_t k = 0; k < changed.size(); ++k) {
      const Coefficients &before = media_[c][k], &now = of_cell[c][k];
      if (now.kappa != before.kappa || now.mu != before.mu) changed[k] = 1;
    }
  }
  std::vector<std::size_t> affected;
  for (std::size_t k = 0; k < walks_.size(); ++k) {
    const std::vector<Step>& steps = walks_[k].steps;
    if (std::any_of(steps.begin(), steps.end(), [&](const Step& step) {
          return changed[static_cast<std::size_t>(step.cell)] != 0;
        })) {
      affected.push_back(k);
    }
  }
  if (static_cast<double>(affected.size()) > most_again * static_cast<double>(walks_.size())) {
    march_all(of_cell, remainder);
    return;
  }
  const OfCell before(media_.begin(), media_.end());
  for (const std::size_t k : affected) {
    const double* power = &power_[k * of_cell.size()];
    march(walks_[k], power, before, remainder, -1.0, load_, balance_);
    march(walks_[k], power, of_cell, remainder, 1.0, load_, balance_);
  }
}

void BeamWalks::add(const ObjectProblem& problem, std::span<const ChannelBeams> channels,
                    double remainder) {
  const std::size_t count = channels.size();
  OfCell of_cell;
  for (const ChannelBeams& channel : channels) of_cell.push_back(channel.of_cell);
  if (same(channels)) {
    march_changed(of_cell, remainder);
  } else {
    enter_all(problem, channels);
    march_all(of_cell, remainder);
  }
  for (std::size_t c = 0; c < count; ++c) {
    channels[c].balance.entering += balance_[c].entering;
    channels[c].balance.absorbed += balance_[c].absorbed;
    channels[c].balance.unscattered += balance_[c].unscattered;
    for (std::size_t i = 0; i < grid_.corner.size(); ++i) {
      channels[c].load[i] += load_[i * count + c];
    }
  }
  if (!keep_) return;
  media_.clear();
  for (const ChannelBeams& channel : channels) {
    media_.emplace_back(channel.of_cell.begin(), channel.of_cell.end());
  }
}

}  // namespace kappamu::forward::polygrid
