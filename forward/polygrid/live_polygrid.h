// A live object on a polygrid: the equations and the last fluence of its channels, from light to
// light and from shape to shape.
#pragma once

#include "forward/live_model.h"
#include "forward/polygrid/polygrid_diffusion.h"

namespace kappamu::forward {

class LivePolygrid final : public LiveModel {
 public:
  /// What these and the beams' distance leave of the exitance: `kappamu bench polygrid --section
  /// frames`.
  static constexpr polygrid::PolygridAccuracy accuracy{
      .linear_tolerance = 2e-2, .beam_remainder = 1e-2, .most_iterations = 100};
  /// Of some 12,000 beams on all of the surface: their distance bounds the light's time and error.
  static double beam_spacing_mm(const Surface& surface);

  /// Throws InputError as make_polygrid() does.
  LivePolygrid(const LiveBody& object, const std::string& device);

  double beam_spacing_mm() const override { return beam_spacing_mm(object_.surface); }
  Answer solve(const LightOfChannels& light) override;
  /// Cells move with the surface, and answers start from the former one, as long as cells stay
  /// valid.
  bool follow(double most_ms) override;
  /// Of the G channel, by an answer on cells split in eight.
  double measured_error(const LightOfChannels& light,
                        const ExitanceOfChannels& exitance) const override;

 private:
  LiveBody object_;
  std::string device_;
  TriangleMesh shape_;  ///< that the cells are of
  std::unique_ptr<polygrid::PolygridDiffusion> diffusion_;
  MediaOfChannels media_;  ///< that the equations are of
};

}  // namespace kappamu::forward
