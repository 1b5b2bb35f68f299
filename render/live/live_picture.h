// The picture of a scene that is looked at, as `kappamu render` makes it: ray by ray, with
// reflections and single scattering, pass by pass while nothing moves.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/picture/picture.h"

namespace kappamu::render {

/// What is looked at, and how finely.
struct PictureView {
  Camera camera;
  int width = 1, height = 1;  ///< [px]
  int samples = 16;           ///< rays a pixel at rest

  bool operator==(const PictureView&) const = default;
};

class LivePicture {
 public:
  /// The next picture of the same light, with twice the rays of the one before; none: it has
  /// `view.samples` a pixel. What it refers to stays where it is until reset().
  std::optional<Picture> next(const World& world, const Environment* environment,
                              const std::vector<ObjectExitance>& exitance, const PictureView& view,
                              std::uint64_t seed, Progress& progress);
  /// Lights, shapes or media are others.
  void reset();

 private:
  LightSources sources_;
  std::unique_ptr<Shading> shading_;  ///< of all views
  std::unique_ptr<PictureMaker> maker_;
  PictureView view_;  ///< of `maker_`
};

}  // namespace kappamu::render
