// A camera's picture of a scene, pixel by pixel in passes that each double the camera's rays.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/progress.h"
#include "render/look_at.h"
#include "render/picture/shading.h"

namespace kappamu::render {

struct Picture {
  Image<float> radiance;      ///< R, G, B; the mean over each pixel's square
  Image<float> coverage;      ///< share of the pixel that objects cover
  double standard_error = 0;  ///< root mean square over covered pixels of the luminance's, relative
                              ///< to their mean luminance
};

/// What pictures of this size need while they are made [bytes].
double picture_memory(const Film& film);

/// A picture that is made pass by pass, the first of one ray a pixel.
class PictureMaker {
 public:
  PictureMaker(const Camera& camera, const Film& film, std::uint64_t seed);
  ~PictureMaker();

  /// Whether there are as many rays a pixel as the film asks for.
  bool done() const { return rays_ >= film_.samples; }
  /// As many rays as all before. Where the listener ends the work, this picture cannot go on.
  void pass(const Shading& shading, Progress& progress);
  Picture picture() const;

 private:
  struct Sums;

  LookAt look_;
  Film film_;
  std::uint64_t seed_;
  int rays_ = 0;  ///< a pixel, so far
  std::vector<Sums> pixels_;
  std::string detail_;
};

Picture render_picture(const Shading& shading, const Camera& camera, const Film& film,
                       std::uint64_t seed, Progress& progress);

/// The factor that puts the 95th percentile of covered pixels' luminance at 0.6; 1 where nothing is
/// covered or lit.
double usual_exposure(const Picture& picture);

/// sRGB: linear up to 0.6 of white; above, the brightest channel bends towards white and the others
/// follow in proportion.
Image<std::uint8_t> tone_mapped(const Image<float>& radiance, double exposure);

}  // namespace kappamu::render
