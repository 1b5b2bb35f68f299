// A live object that is a box of whole voxels: its grid, with the equations and the last fluence of
// its channels.
#pragma once

#include "forward/block/block_diffusion.h"
#include "render/live/live_object.h"

namespace kappamu::render {

class LiveBlock final : public LiveObject {
 public:
  /// Throws InputError where the object is no block.
  LiveBlock(const WorldObject& object, const std::string& device);

  double beam_spacing_mm() const override { return 0.5 * grid_.shape.voxel_mm; }
  Answer solve(const LightOfChannels& light) override;
  /// Of the G channel, by an answer on voxels half as large.
  double measured_error(const LightOfChannels& light,
                        const ExitanceOfChannels& exitance) const override;

 private:
  const WorldObject& object_;
  std::string device_;
  forward::block::BlockGrid grid_;
  forward::block::FaceMap map_;
  std::vector<std::unique_ptr<forward::block::BlockDiffusion>> channels_;
  MediaOfChannels media_;  ///< that the equations are of
};

}  // namespace kappamu::render
