// A live object on polygrids: a coarse one while lights or the shape move, finer ones at rest, each
// with its equations and the last fluence of its channels.
#pragma once

#include "forward/live_model.h"
#include "forward/polygrid/polygrid_diffusion.h"

namespace kappamu::forward {

class LivePolygrid final : public LiveModel {
 public:
  /// At level 0. What these and the beams' distance leave of the exitance: `kappamu-studies
  /// polygrid
  /// --section frames`.
  static constexpr polygrid::PolygridAccuracy accuracy{
      .linear_tolerance = 2e-2, .beam_remainder = 1e-2, .most_iterations = 100};
  /// Of some 12,000 beams on all of the surface: their distance bounds the light's time and error.
  static double beam_spacing_mm(const Surface& surface);

  /// The first level has some `first_cells`, each other one eight times those of the one before, as
  /// many as [W]'s largest object, the memory and `options.max_elements` allow. Throws InputError
  /// as make_polygrid() does.
  LivePolygrid(const LiveBody& object, int first_cells, const ObjectOptions& options,
               Progress& progress);

  int levels() const override { return levels_; }
  double beam_spacing_mm() const override { return beam_spacing_mm(object_.surface); }
  Answer solve(const LightOfChannels& light, int level, Progress& progress) override;
  /// Of the G channel, by the level before.
  std::optional<double> measured_error(const LightOfChannels& light, int level,
                                       const ExitanceOfChannels& fine,
                                       const ExitanceOfChannels& coarse) const override;
  /// The coarsest cells move with the surface, and answers start from the former one, as long as
  /// cells stay valid.
  bool follow(double most_ms) override;

 private:
  struct Level {
    std::unique_ptr<polygrid::PolygridDiffusion> diffusion;
    MediaOfChannels media;  ///< that the equations are of
  };
  void add(Polygrid grid);
  Level& at(int level, Progress& progress);

  LiveBody object_;
  std::string device_;
  std::vector<Level> made_;
  int levels_ = 1;
  TriangleMesh shape_;  ///< that the cells are of
};

}  // namespace kappamu::forward
