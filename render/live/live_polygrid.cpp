#include "render/live/live_polygrid.h"

#include <algorithm>
#include <cmath>

#include "forward/polygrid/polygrid_solve.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/polygrid/split_polygrid.h"

namespace kappamu::render {

namespace {

using forward::polygrid::PolygridAnswer;
using forward::polygrid::PolygridDiffusion;

/// Beside a picture's own steps of 1/255: the residual leaves at most 0.1 % of the exitance's
/// 2-norm (docs/polygrid-diffusion.md, "Live").
constexpr forward::polygrid::PolygridAccuracy polygrid_accuracy{
    .linear_tolerance = 1e-2, .beam_remainder = 1e-3, .most_iterations = 100};
constexpr int cells = 20'000;

}  // namespace

LivePolygrid::LivePolygrid(const WorldObject& object, const std::string& device)
    : object_(object), device_(device) {
  Progress silent;
  forward::PolygridOptions options;
  options.cells = cells;
  forward::MadePolygrid made = forward::make_polygrid(object.mesh, options, silent);
  double area = 0.0;
  for (const double of_side : made.grid.area) area += of_side;
  spacing_mm_ = 0.5 * std::sqrt(area / static_cast<double>(made.grid.area.size()));
  diffusion_ = std::make_unique<PolygridDiffusion>(
      std::move(made.grid), object.mesh, object.surface, object.boundary.eta, device, true);
}

LivePolygrid::Answer LivePolygrid::solve(const LightOfChannels& light) {
  if (media_ != object_.media.channels) {
    media_ = object_.media.channels;
    diffusion_->set_media(
        std::array<const ObjectMedium*, 3>{media_[0].get(), media_[1].get(), media_[2].get()});
  }
  const ChannelProblems problems(object_, light);
  std::vector<PolygridAnswer> solved = diffusion_->solve(problems.of, polygrid_accuracy);
  Answer answer;
  answer.iterations = diffusion_->report().iterations;
  answer.converged = diffusion_->report().converged;
  for (std::size_t c = 0; c < 3; ++c) answer.exitance[c] = std::move(solved[c].exitance);
  return answer;
}

double LivePolygrid::measured_error(const LightOfChannels& light,
                                    const ExitanceOfChannels& exitance) const {
  constexpr std::size_t channel = 1;
  const ChannelProblems problems(object_, light);
  PolygridDiffusion finer(forward::polygrid::split(diffusion_->grid(), object_.mesh), object_.mesh,
                          object_.surface, object_.boundary.eta, device_);
  finer.set_media(std::array<const ObjectMedium*, 1>{object_.media.channels[channel].get()});
  const std::vector<PolygridAnswer> fine =
      finer.solve(std::span(problems.of).subspan(channel, 1), polygrid_accuracy);
  return forward::polygrid_errors(problems.of[channel], exitance[channel], fine[0].exitance)
      .front();
}

}  // namespace kappamu::render
