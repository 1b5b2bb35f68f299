// Light from all directions: a latitude-longitude image of radiance, sampled by its brightness.
//
// The image's top row looks up (+y), its columns run left to right from +z over −x ... the centre
// column looks along −z (the direction a camera at +z looks), +x lies a quarter of the width to the
// right of the centre. Radiance is even within a pixel, so that sampling by pixels is exact.
//
// What is drawn by brightness is what exceeds the even part, the lesser of mean and median over
// solid angle; that is left to the directions that a surface draws, with which it is weighted (MIS
// compensation: Karlík et al. 2019). What exceeds it is lamps, whose directions count where their
// light enters a body (sky_beams.h).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/image.h"
#include "render/colour.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// An environment's lamps light bodies evenly, as the rest of it, or along their own directions.
enum class LampsEnter { evenly, as_beams };

class Environment {
 public:
  /// Reads the image, if any. Throws InputError naming the file.
  explicit Environment(const EnvironmentLight& light, LampsEnter lamps = LampsEnter::evenly);

  struct Sample {
    Eigen::Vector3d direction;  ///< towards the light
    Colour radiance;
    double density = 0.0;  ///< of the direction [1/sr]
  };

  Colour radiance(const Eigen::Vector3d& direction) const;
  /// Of the radiance there, what exceeds the even part in luminance, in its own colour.
  Colour of_lamps(const Eigen::Vector3d& direction) const;
  /// The direction that (u, v) in [0, 1)² stands for; not to be asked of an even environment.
  Sample sample(double u, double v) const;
  /// Of what sample() draws [1/sr]; zero where there is no lamp.
  double density(const Eigen::Vector3d& direction) const;
  bool even() const { return cumulative_.back() <= 0.0; }
  /// There are lamps, and they enter bodies as beams.
  bool has_beams() const { return lamps_ == LampsEnter::as_beams && !even(); }
  bool visible() const { return visible_; }
  bool dark() const { return dark_; }
  const Image<float>& image() const { return image_; }  ///< R, G, B of radiance, before the turn
  double turn() const { return turn_; }                 ///< about y [rad]

 private:
  std::size_t pixel_of(const Eigen::Vector3d& direction) const;
  double solid_angle(std::size_t pixel) const;
  double median_of(const std::vector<double>& bright) const;

  Image<float> image_;
  std::vector<double> cumulative_;  ///< of lamps' luminance × solid angle, over pixels [y][x]
  double turn_ = 0.0;               ///< about y [rad]
  double even_ = 0.0;               ///< luminance of the even part; rounding is no lamp
  LampsEnter lamps_;
  bool visible_ = true, dark_ = true;
};

/// Of the scene's environment; none where it has none or a dark one.
std::optional<Environment> make_environment(const std::vector<Light>& lights,
                                            LampsEnter lamps = LampsEnter::evenly);

}  // namespace kappamu::render
