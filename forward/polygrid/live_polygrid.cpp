#include "forward/polygrid/live_polygrid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "forward/polygrid/polygrid_solve.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/polygrid/shape/moved_polygrid.h"
#include "forward/polygrid/split_polygrid.h"

namespace kappamu::forward {

namespace {

using polygrid::PolygridAnswer;
using polygrid::PolygridDiffusion;

constexpr int live_cells = 20'000;
constexpr double most_places = 12'000.0;

}  // namespace

double LivePolygrid::beam_spacing_mm(const Surface& surface) {
  return std::sqrt(std::accumulate(surface.area.begin(), surface.area.end(), 0.0) / most_places);
}

LivePolygrid::LivePolygrid(const LiveBody& object, const std::string& device)
    : object_(object), device_(device), shape_(object.mesh) {
  Progress silent;
  PolygridOptions options;
  options.cells = live_cells;
  options.drawn = object.polycube;
  MadePolygrid made = make_polygrid(object.mesh, options, silent);
  diffusion_ =
      std::make_unique<PolygridDiffusion>(std::move(made.grid), object.mesh, object.surface,
                                          object.eta, device, polygrid::Lights::moving);
}

bool LivePolygrid::follow(double /*most_ms*/) {
  std::optional<Polygrid> grid =
      moved_polygrid(diffusion_->grid(), shape_, object_.mesh, PolygridOptions().first_layer);
  if (!grid) return false;
  shape_ = object_.mesh;
  auto moved = std::make_unique<PolygridDiffusion>(std::move(*grid), object_.mesh, object_.surface,
                                                   object_.eta, device_, polygrid::Lights::moving);
  moved->start_from(*diffusion_);
  diffusion_ = std::move(moved);
  media_ = {};
  return true;
}

LivePolygrid::Answer LivePolygrid::solve(const LightOfChannels& light) {
  if (media_ != object_.media) {
    media_ = object_.media;
    diffusion_->set_media(
        std::array<const ObjectMedium*, 3>{media_[0].get(), media_[1].get(), media_[2].get()});
  }
  const ChannelProblems problems(object_, light);
  std::vector<PolygridAnswer> solved = diffusion_->solve(problems.all(), accuracy);
  Answer answer;
  answer.iterations = diffusion_->report().iterations;
  answer.converged = diffusion_->report().converged;
  answer.residual =
      *std::max_element(diffusion_->report().residual.begin(), diffusion_->report().residual.end());
  for (std::size_t c = 0; c < 3; ++c) answer.exitance[c] = std::move(solved[c].exitance);
  return answer;
}

double LivePolygrid::measured_error(const LightOfChannels& light,
                                    const ExitanceOfChannels& exitance) const {
  constexpr std::size_t channel = 1;
  const ChannelProblems problems(object_, light);
  PolygridDiffusion finer(polygrid::split(diffusion_->grid(), object_.mesh), object_.mesh,
                          object_.surface, object_.eta, device_);
  finer.set_media(std::array<const ObjectMedium*, 1>{object_.media[channel].get()});
  const std::vector<PolygridAnswer> fine =
      finer.solve(problems.all().subspan(channel, 1), accuracy);
  return polygrid_errors(problems[channel], diffusion_->surface_map().gaps(), exitance[channel],
                         fine[0].exitance)
      .front();
}

}  // namespace kappamu::forward
