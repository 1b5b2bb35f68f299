// What changes from light to light of a scene's object on a polygrid: its right-hand sides alone.
#pragma once

#include "forward/polygrid/polygrid_diffusion.h"
#include "render/live/live_block.h"

namespace kappamu::render {

/// An object's polygrid, with the equations and the last fluence of its channels.
class LivePolygrid {
 public:
  using Answer = LiveBlock::Answer;

  /// Keeps a reference to the object; its media may change between answers, not its mesh. Throws
  /// InputError as make_polygrid() does.
  LivePolygrid(const WorldObject& object, const std::string& device);

  /// Beams closer than this tell these cells nothing more [mm].
  double beam_spacing_mm() const { return spacing_mm_; }

  Answer solve(const std::array<forward::ObjectLight, 3>& light);
  /// Relative error of the G channel's exitance, by an answer on cells split in eight.
  double measured_error(const std::array<forward::ObjectLight, 3>& light,
                        const std::array<std::vector<double>, 3>& exitance) const;

 private:
  const WorldObject& object_;
  std::string device_;
  std::unique_ptr<forward::polygrid::PolygridDiffusion> diffusion_;
  double spacing_mm_ = 0.0;
  std::array<std::shared_ptr<const ObjectMedium>, 3> media_;  ///< that the equations are of
};

}  // namespace kappamu::render
