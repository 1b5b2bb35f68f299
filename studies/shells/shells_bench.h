// Fur measured: coverage against [K]'s approximations, what breaks symmetry, transfer by bands and
// rays against rays to the light, shells against the integral along the eye's ray, figures.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "forward/shells/lit_hair.h"
#include "studies/subject.h"

namespace kappamu::studies {

/// Rows per formula: largest and mean error of [K] eq. 1 and 2 and of the four cases they make.
void fur_coverage(const Request& request, Progress& progress, const Save& save);
/// Rows per variant: what a turn, a mirror and the side of the light change.
void fur_symmetry(const Request& request, Progress& progress, const Save& save);
/// Rows per light, bands and rays.
void fur_transfer(const Request& request, Progress& progress, const Save& save);
/// Rows per light: pictures by shells against pictures by rays.
void fur_reference(const Request& request, Progress& progress, const Save& save);
/// Rows per step: seconds by the clock and of the processor; C++ and OpenCL in turns.
void fur_speed(const Request& request, Progress& progress, const Save& save);
/// Rows per view and width of a pixel: fewer shells against all of them.
void fur_detail(const Request& request, Progress& progress, const Save& save);
/// PNG files of a flat coat: [K]'s figures 1, 3, 4 and 5.
void fur_figures(const Request& request, Progress& progress, const Save& save);

/// Light over the sphere of radiance(direction), and its name.
struct SkyLight {
  std::string name;
  std::function<double(const Eigen::Vector3d& towards)> radiance;
};
/// Even sky; a lobe from 45° and one from 75° beside the normal (cos⁴ of the angle); a small bright
/// lobe (cos⁶⁴), sharper than five bands.
std::vector<SkyLight> four_lights();
/// Coefficients of a light, one column.
Eigen::MatrixXd projected(const SkyLight& light, int bands);

/// A coat that goes on for ever under a pinhole.
struct FlatView {
  Eigen::Vector3d eye, target;  ///< [texel]
  double fov_deg = 30.0;
  int width = 640, height = 512, samples = 4;
};
/// Three channels; `dark` below what hairs leave free.
using SeenAlong = std::function<forward::shells::SeenHair(const Eigen::Vector3d& origin,
                                                          const Eigen::Vector3d& direction)>;
Image<float> flat_picture(const FlatView& view, const SeenAlong& seen);

}  // namespace kappamu::studies
