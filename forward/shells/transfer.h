// How much of the light from all directions reaches each texel of a hair texture ([K] eq. 4), as
// coefficients of spherical harmonics. The volume repeats along x and y; light ends at the skin
// below it and comes unhindered from above.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/progress.h"
#include "forward/shells/hair_texture.h"
#include "forward/shells/harmonics.h"

namespace kappamu::forward::shells {

/// Over the sphere, of low discrepancy, in sets of eight that turns by 90° about z and mirrors
/// along x and y map onto each other: transfer and light keep those symmetries to rounding. `count`
/// is rounded up to a multiple of sixteen.
std::vector<Eigen::Vector3d> even_directions(int count);

/// T = exp(−r Σ ρ·length) from a point [texel] along a direction of unit length: the way through
/// each texel times its density. Zero below the horizon, where the skin is.
double transmittance(const HairTexture& texture, double r, const Eigen::Vector3d& point,
                     const Eigen::Vector3d& direction);

/// The same volume without neighbours, as [K] has it: light enters by its sides.
double transmittance_alone(const HairTexture& texture, double r, const Eigen::Vector3d& point,
                           const Eigen::Vector3d& direction);

Eigen::Vector3d centre_of(const HairTexture& texture, std::size_t texel);

struct TransferOptions {
  int bands = 5;    ///< 1 to 6; [K]: 5
  int rays = 1024;  ///< over the whole sphere
  double r = 0.0;   ///< [1/texel]; 0: the texture's own extinction
};

struct Transfer {
  int bands = 0;
  double r = 0.0;             ///< [1/texel]
  std::vector<float> values;  ///< [texel][l(l+1)+m]; zero in air

  /// ∫ L T dω of light whose coefficients are given, one column per colour channel.
  Eigen::RowVectorXd lit(std::size_t texel, const Eigen::MatrixXd& light) const {
    const auto size = static_cast<Eigen::Index>(harmonics_in(bands));
    const Eigen::Map<const Eigen::VectorXf> row(
        values.data() + texel * static_cast<std::size_t>(size), size);
    return row.cast<double>().transpose() * light;
  }
};

/// Throws InputError naming option and bound.
Transfer make_transfer(const HairTexture& texture, const TransferOptions& options,
                       Progress& progress);

}  // namespace kappamu::forward::shells
