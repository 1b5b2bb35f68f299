#include "forward/block/live_block.h"

#include <algorithm>

#include "forward/block/block_model.h"

namespace kappamu::forward {

namespace {

using block::BlockDiffusion;

/// Beside a picture's own steps of 1/255.
constexpr block::BlockAccuracy block_accuracy{.linear_tolerance = 1e-4, .beam_remainder = 1e-3};

}  // namespace

LiveBlock::LiveBlock(const LiveBody& object, const std::string& device)
    : object_(object),
      device_(device),
      grid_(block::require_block_grid(object.mesh, *object.media[0])),
      map_(grid_, object.mesh, object.surface) {
  for (int c = 0; c < 3; ++c) {
    channels_.push_back(std::make_unique<BlockDiffusion>(grid_, map_, object.eta, device));
  }
}

LiveBlock::Answer LiveBlock::solve(const LightOfChannels& light, int /*level*/,
                                   Progress& progress) {
  const ChannelProblems problems(object_, light);
  Answer answer;
  answer.elements = grid_.shape.cells();
  for (std::size_t c = 0; c < 3; ++c) {
    progress.update("grid", static_cast<double>(c) / 3.0, "");
    if (media_[c] != object_.media[c]) {
      channels_[c]->set_medium(*object_.media[c]);
      media_[c] = object_.media[c];
    }
    block::BlockAnswer solved = channels_[c]->solve(problems[c], block_accuracy);
    answer.iterations = std::max(answer.iterations, solved.report.iterations);
    answer.residual = std::max(answer.residual, solved.report.residual.at(0));
    answer.converged = answer.converged && solved.report.termination == Termination::converged;
    answer.exitance[c] = std::move(solved.exitance);
  }
  return answer;
}

std::optional<double> LiveBlock::measured_error(const LightOfChannels& light, int /*level*/,
                                                const ExitanceOfChannels& exitance,
                                                const ExitanceOfChannels& /*coarse*/) const {
  constexpr std::size_t channel = 1;
  const ChannelProblems problems(object_, light);
  const block::BlockGrid finer = grid_.refined(2);
  const block::FaceMap map(finer, object_.mesh, object_.surface);
  BlockDiffusion diffusion(finer, map, object_.eta, device_);
  diffusion.set_medium(*object_.media[channel]);
  const block::BlockAnswer fine = diffusion.solve(problems[channel], block_accuracy);
  return block_errors(problems[channel], exitance[channel], fine.exitance).front();
}

}  // namespace kappamu::forward
