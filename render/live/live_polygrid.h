// A live object on a polygrid: the equations and the last fluence of its channels.
#pragma once

#include "forward/polygrid/polygrid_diffusion.h"
#include "render/live/live_object.h"

namespace kappamu::render {

class LivePolygrid final : public LiveObject {
 public:
  /// Beside a picture's own steps of 1/255: what these and beams as far apart as sides of the
  /// boundary change in the exitance is measured by `kappamu bench polygrid --section frames`.
  static constexpr forward::polygrid::PolygridAccuracy accuracy{
      .linear_tolerance = 2e-2, .beam_remainder = 1e-2, .most_iterations = 100};
  static double beam_spacing_mm(const forward::Polygrid& grid);

  /// Throws InputError as make_polygrid() does.
  LivePolygrid(const WorldObject& object, const std::string& device);

  double beam_spacing_mm() const override { return spacing_mm_; }
  Answer solve(const LightOfChannels& light) override;
  /// Of the G channel, by an answer on cells split in eight.
  double measured_error(const LightOfChannels& light,
                        const ExitanceOfChannels& exitance) const override;

 private:
  const WorldObject& object_;
  std::string device_;
  std::unique_ptr<forward::polygrid::PolygridDiffusion> diffusion_;
  double spacing_mm_ = 0.0;
  MediaOfChannels media_;  ///< that the equations are of
};

}  // namespace kappamu::render
