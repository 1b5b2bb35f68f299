// A live object that is a box of whole voxels: its grid, with the equations and the last fluence of
// its channels.
#pragma once

#include "forward/block/block_diffusion.h"
#include "forward/live_model.h"

namespace kappamu::forward {

class LiveBlock final : public LiveModel {
 public:
  /// Throws InputError where the object is no block.
  LiveBlock(const LiveBody& object, const std::string& device);

  double beam_spacing_mm() const override { return 0.5 * grid_.shape.voxel_mm; }
  Answer solve(const LightOfChannels& light, int level, Progress& progress) override;
  /// Of the G channel, by an answer on voxels half as large.
  std::optional<double> measured_error(const LightOfChannels& light, int level,
                                       const ExitanceOfChannels& fine,
                                       const ExitanceOfChannels& coarse) const override;

 private:
  LiveBody object_;
  std::string device_;
  block::BlockGrid grid_;
  block::FaceMap map_;
  std::vector<std::unique_ptr<block::BlockDiffusion>> channels_;
  MediaOfChannels media_;  ///< that the equations are of
};

}  // namespace kappamu::forward
