#include "forward/polygrid/live_polygrid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/process_memory.h"
#include "forward/polygrid/polygrid_model.h"
#include "forward/polygrid/polygrid_solve.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/polygrid/shape/moved_polygrid.h"
#include "forward/polygrid/split_polygrid.h"

namespace kappamu::forward {

namespace {

using polygrid::PolygridAnswer;
using polygrid::PolygridDiffusion;

/// [W] table III has objects of up to 1.5 million nodes.
constexpr double most_cells = 1.5e6;
/// Of a cell and its three channels [bytes], and the share of the memory that all may take.
constexpr double bytes_of_live_cell = 4500.0, memory_of_levels = 0.4;
constexpr double most_places = 12'000.0;
/// Beyond, a grid is one with an eighth of the cells, split: moving corners takes minutes.
constexpr int most_made = 200'000;
/// Beside a picture's own steps of 1/255.
constexpr polygrid::PolygridAccuracy fine_accuracy{
    .linear_tolerance = 1e-3, .beam_remainder = 1e-3, .most_iterations = 200};

Polygrid polygrid_of(const LiveBody& object, int cells, Progress& progress) {
  PolygridOptions options;
  options.cells = cells;
  options.drawn = object.polycube;
  return make_polygrid(object.mesh, options, progress).grid;
}

}  // namespace

double LivePolygrid::beam_spacing_mm(const Surface& surface) {
  return std::sqrt(std::accumulate(surface.area.begin(), surface.area.end(), 0.0) / most_places);
}

LivePolygrid::LivePolygrid(const LiveBody& object, int first_cells, const ObjectOptions& options,
                           Progress& progress)
    : object_(object), device_(options.device), shape_(object.mesh) {
  const auto made = [&](int of) { return polygrid_of(object, of, progress); };
  if (first_cells <= most_made) {
    add(first_polygrid(first_cells, made));
  } else {
    int coarse = first_cells, splits = 0;
    for (; coarse > most_made; ++splits) coarse /= 8;
    Polygrid grid = first_polygrid(coarse, made);
    for (; splits > 0; --splits) grid = polygrid::split(grid, object.mesh);
    add(std::move(grid));
  }
  double most = std::min(most_cells, memory_of_levels * main_memory() / bytes_of_live_cell);
  if (options.max_elements) most = std::min(most, static_cast<double>(*options.max_elements));
  for (auto cells = 8.0 * static_cast<double>(made_[0].diffusion->grid().cell.size());
       cells <= most; cells *= 8.0) {
    ++levels_;
  }
}

void LivePolygrid::add(Polygrid grid) {
  made_.push_back(
      {std::make_unique<PolygridDiffusion>(std::move(grid), object_.mesh, object_.surface,
                                           object_.eta, device_, polygrid::Lights::moving),
       {}});
}

/// The level next to the coarsest is made anew: it reaches thin parts that the coarsest leaves out.
LivePolygrid::Level& LivePolygrid::at(int level, Progress& progress) {
  while (made_.size() <= static_cast<std::size_t>(level)) {
    const Polygrid& last = made_.back().diffusion->grid();
    const auto cells = 8 * static_cast<int>(last.cell.size());
    progress.update("polygrid", 0.0, std::to_string(cells) + " cells");
    add(made_.size() == 1 ? polygrid_of(object_, cells, progress)
                          : polygrid::split(last, object_.mesh));
  }
  return made_[static_cast<std::size_t>(level)];
}

bool LivePolygrid::follow(double /*most_ms*/) {
  const PolygridDiffusion& former = *made_[0].diffusion;
  std::optional<Polygrid> grid =
      moved_polygrid(former.grid(), shape_, object_.mesh, PolygridOptions().first_layer);
  if (!grid) return false;
  auto moved = std::make_unique<PolygridDiffusion>(std::move(*grid), object_.mesh, object_.surface,
                                                   object_.eta, device_, polygrid::Lights::moving);
  moved->start_from(former);
  made_.clear();
  made_.push_back({std::move(moved), {}});
  shape_ = object_.mesh;
  return true;
}

LivePolygrid::Answer LivePolygrid::solve(const LightOfChannels& light, int level,
                                         Progress& progress) {
  Level& used = at(level, progress);
  PolygridDiffusion& diffusion = *used.diffusion;
  progress.update("diffusion", 0.0, std::to_string(diffusion.grid().cell.size()) + " cells");
  if (used.media != object_.media) {
    diffusion.set_media(std::array<const ObjectMedium*, 3>{
        object_.media[0].get(), object_.media[1].get(), object_.media[2].get()});
    used.media = object_.media;
  }
  const ChannelProblems problems(object_, light);
  std::vector<PolygridAnswer> solved =
      diffusion.solve(problems.all(), level == 0 ? accuracy : fine_accuracy);
  Answer answer;
  answer.elements = diffusion.grid().cell.size();
  answer.iterations = diffusion.report().iterations;
  answer.converged = diffusion.report().converged;
  answer.residual =
      *std::max_element(diffusion.report().residual.begin(), diffusion.report().residual.end());
  for (std::size_t c = 0; c < 3; ++c) answer.exitance[c] = std::move(solved[c].exitance);
  return answer;
}

std::optional<double> LivePolygrid::measured_error(const LightOfChannels& light, int level,
                                                   const ExitanceOfChannels& fine,
                                                   const ExitanceOfChannels& coarse) const {
  constexpr std::size_t channel = 1;
  if (coarse[channel].empty()) return std::nullopt;
  const ChannelProblems problems(object_, light);
  const Level& used = made_[static_cast<std::size_t>(level)];
  return polygrid_errors(problems[channel], used.diffusion->surface_map().gaps(), coarse[channel],
                         fine[channel])
      .front();
}

}  // namespace kappamu::forward
