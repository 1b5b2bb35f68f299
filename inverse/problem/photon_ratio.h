// Transport's answer over diffusion's, by following photons (forward/montecarlo) through the volume
// that diffusion was solved for: the share of the correction r (objective.h) that carries a fit
// from diffusion's answer to transport's.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/grid.h"
#include "forward/block_setup.h"

namespace kappamu::inverse {

/// Which equation a fit's predictions obey.
enum class Physics {
  diffusion,
  transport,  ///< radiative transfer through r
  automatic   ///< transport where its homogeneous block is another than diffusion's
};

/// Photons wherever a fit needs transport's answer.
struct PhotonOptions {
  std::string device = "auto";  ///< OpenCL; there is no serial reference
  /// Seed of the fit. Every call draws the same random numbers (their key is none that `kappamu
  /// simulate` or `forward` draw from): r then moves with the volume, not with chance, and its
  /// iteration ends.
  std::uint64_t seed = 1;
  /// Relative noise of a pixel that suffices, however exact its datum, with nothing smoothed; 0:
  /// none does.
  double pilot_noise = 0.0;
  /// Deviation of the photons' noise, as smoothed, over what the end of a fit asks for: 2 makes do
  /// with a quarter of the photons.
  double noise = 1.0;
  double anisotropy = 0.0;  ///< Henyey-Greenstein g, σs = σs'/(1 − g)
};

/// Difference of log κ, and of log μ, that the slope of the ratio is taken over: downwards, where
/// no voxel comes to scatter nothing.
inline constexpr double slope_step = 0.2;

/// Light, medium and pixels of a photon walk.
struct PhotonProblem {
  forward::GridSetup setup;        ///< of the grid the photons walk on
  std::vector<double> kappa;       ///< [mm] on that grid, [z][y][x]
  std::vector<double> mu;          ///< [1/mm]
  std::vector<double> irradiance;  ///< [M][v][u] on its lit face
  Face seen_face = Face::z_plus;
  std::vector<Face> seen_faces;  ///< as those of SurfaceMeasurements
  FaceShape seen_shape;          ///< of what follows: pixels of `factor`² of the grid's own
  int factor = 1;
  int patterns = 0;                 ///< M
  Cameras cameras{};                ///< transport's exitance is what they see (ForwardOptions)
  std::vector<double> diffusion{};  ///< M by diffusion [M][v][u]
  /// Variance of the datum that the ratio times `diffusion` is compared with [M][v][u], infinite
  /// where there is none.
  std::vector<double> variance{};
  /// M by diffusion where log κ, and where log μ, is less by slope_step in all voxels; empty: no
  /// slope is asked for.
  std::array<std::vector<double>, 2> diffusion_below{};
};

struct PhotonRatio {
  std::vector<double> ratio;  ///< transport over diffusion [M][v][u]; 1 where nothing is lit
  /// Variance of ratio × diffusion by the photons' noise, as smoothed; neighbours share it.
  std::vector<double> variance;
  /// The same of single pixels, independent: what smoothing cannot take from sums over many.
  std::vector<double> pixel_variance;
  std::uint64_t photons = 0;  ///< of each pattern, of all walks
  /// ∂ log ratio/∂ log κ and ∂ log μ of all voxels together [M][v][u]; empty where not asked for.
  std::array<std::vector<double>, 2> slope{};
};

/// Photons per pattern are chosen so that a pixel's noise is, in the median, as large as its
/// datum's deviation (a power of two, 2¹⁴ to 2²²). Ratio of Gaussian means of both maps over the
/// face, its width for each pixel the least of 0, ½, ½√2, 1, … voxels that brings the noise to half
/// of that deviation; of single pixels where its slope is asked for, by a regression of single
/// pixels' (docs/theory.md) from walks of their own. Voxels that leave no scattering (3κμ ≥ 1) are
/// followed as almost pure absorbers, those of κ below a 50th of the median or a 600th of the voxel
/// as if κ were that. Throws InputError where there is no OpenCL device.
PhotonRatio photon_ratio(const PhotonProblem& problem, const PhotonOptions& options);

}  // namespace kappamu::inverse
