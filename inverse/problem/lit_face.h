// Light that leaves a homogeneous block where the light falls: transport's reflectance of a slab at
// each spatial frequency of the light (forward/lateral), times what the block's sides change by
// diffusion. It holds where light varies slowly over the face, as even light and sinusoids do, and
// for one κ and one μ: volumes leave lit pixels out.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/numbers/cosine_transform.h"
#include "core/surface_measurements.h"
#include "forward/block_setup.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// g of what is lit; the error allows for other tissue, food and paint.
inline constexpr double lit_anisotropy = 0.9, lit_anisotropy_deviation = 0.05;

class LitFace {
 public:
  /// For the pictures that problem.lateral names.
  explicit LitFace(const Problem& problem);

  /// Exitance [M][v][u] for κ [mm] and μ [1/mm]; 0 on other pictures.
  std::vector<double> exitance(double kappa, double mu) const;
  /// Its standard error, relative: the table's, and that of g.
  double error(double kappa, double mu) const;

 private:
  std::vector<double> by_sides(double kappa, double mu) const;

  forward::GridSetup setup_;
  FaceShape face_;
  int patterns_;
  std::vector<int> pictures_;
  std::vector<double> irradiance_;  ///< of pictures_
  double index_;
  CosineTransform cosines_u_, cosines_v_;
  std::vector<Eigen::MatrixXd> waves_;  ///< of each of pictures_ [wave of u][wave of v]
};

/// Whether the light of one picture on the lit face [v][u] varies slowly enough: of its power but
/// the mean, a thousandth at most lies beyond 0.5 /mm or half of what its pixels resolve.
bool varies_slowly(const FaceShape& face, double voxel_mm, const std::vector<double>& irradiance);

struct LitPixelUse {
  SurfaceMeasurements measurements;
  /// Of the noisiest picture: white noise that its values show, and the mean of what they state,
  /// relative to its mean value. Where they show more, it has taken the place of their variance.
  double noise = 0.0, stated = 0.0;
};

/// The measurements with their lit pixels used under such light; those of one picture have one
/// variance. Throws InputError, one sentence, where none can be: no lit pixels, other than
/// collimated light, or an index beyond the table.
LitPixelUse with_lit_pixels(const SurfaceMeasurements& measurements);
/// The same in place; nothing changes where none can be used.
void use_lit_pixels(SurfaceMeasurements& measurements);

}  // namespace kappamu::inverse
