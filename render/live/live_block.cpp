#include "render/live/live_block.h"

#include <algorithm>

#include "forward/block/block_model.h"

namespace kappamu::render {

namespace {

using forward::block::BlockDiffusion;

/// Beside a picture's own steps of 1/255.
constexpr forward::block::BlockAccuracy block_accuracy{.linear_tolerance = 1e-4,
                                                       .beam_remainder = 1e-3};

}  // namespace

LiveBlock::LiveBlock(const WorldObject& object, const std::string& device)
    : object_(object),
      device_(device),
      grid_(forward::block::require_block_grid(object.mesh, *object.media.channels[0])),
      map_(grid_, object.mesh, object.surface) {
  for (int c = 0; c < 3; ++c) {
    channels_.push_back(std::make_unique<BlockDiffusion>(grid_, map_, object.boundary.eta, device));
  }
}

LiveBlock::Answer LiveBlock::solve(const LightOfChannels& light) {
  const ChannelProblems problems(object_, light);
  Answer answer;
  for (std::size_t c = 0; c < 3; ++c) {
    if (media_[c] != object_.media.channels[c]) {
      channels_[c]->set_medium(*object_.media.channels[c]);
      media_[c] = object_.media.channels[c];
    }
    forward::block::BlockAnswer solved = channels_[c]->solve(problems.of[c], block_accuracy);
    answer.iterations = std::max(answer.iterations, solved.report.iterations);
    answer.residual = std::max(answer.residual, solved.report.residual.at(0));
    answer.converged =
        answer.converged && solved.report.termination == forward::Termination::converged;
    answer.exitance[c] = std::move(solved.exitance);
  }
  return answer;
}

double LiveBlock::measured_error(const LightOfChannels& light,
                                 const ExitanceOfChannels& exitance) const {
  constexpr std::size_t channel = 1;
  const ChannelProblems problems(object_, light);
  const forward::block::BlockGrid finer = grid_.refined(2);
  const forward::block::FaceMap map(finer, object_.mesh, object_.surface);
  BlockDiffusion diffusion(finer, map, object_.boundary.eta, device_);
  diffusion.set_medium(*object_.media.channels[channel]);
  const forward::block::BlockAnswer fine = diffusion.solve(problems.of[channel], block_accuracy);
  return forward::block_errors(problems.of[channel], exitance[channel], fine.exitance).front();
}

}  // namespace kappamu::render
