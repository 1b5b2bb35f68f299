// What changes from light to light of a scene's object that is a box: its right-hand sides alone.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "forward/block/block_diffusion.h"
#include "render/scene/world.h"

namespace kappamu::render {

/// One light's problem in each of three channels.
struct ChannelProblems {
  ChannelProblems(const WorldObject& object, const std::array<forward::ObjectLight, 3>& light);

  std::array<std::vector<forward::ObjectLight>, 3> lights;
  std::vector<forward::ObjectProblem> of;  ///< refers to `lights` and the object
};

/// A block's grid, with the equations and the last fluence of its channels.
class LiveBlock {
 public:
  struct Answer {
    std::array<std::vector<double>, 3> exitance;  ///< per triangle
    int iterations = 0;                           ///< of the slowest channel
    bool converged = true;
  };

  /// Keeps a reference to the object; its media may change between answers, not its mesh. Throws
  /// InputError where it is no block.
  LiveBlock(const WorldObject& object, const std::string& device);

  /// Beams closer than this tell these voxels nothing more [mm].
  double beam_spacing_mm() const { return 0.5 * grid_.shape.voxel_mm; }

  Answer solve(const std::array<forward::ObjectLight, 3>& light);
  /// Relative error of the G channel's exitance, by an answer on voxels half as large.
  double measured_error(const std::array<forward::ObjectLight, 3>& light,
                        const std::array<std::vector<double>, 3>& exitance) const;

 private:
  const WorldObject& object_;
  std::string device_;
  forward::block::BlockGrid grid_;
  forward::block::FaceMap map_;
  std::vector<std::unique_ptr<forward::block::BlockDiffusion>> channels_;
  std::array<std::shared_ptr<const ObjectMedium>, 3> media_;  ///< that the equations are of
};

}  // namespace kappamu::render
