// The simulated samples: blocks of known κ(x), μ(x) in R, G, B.
//
// Base coefficients per mm: marble as measured by Jensen et al. 2001, table 1 (σs' 2.19 2.62 3.00,
// σa 0.0021 0.0041 0.0071); waxes and cast stone in the range published for paraffin and candle wax
// and for onyx-like stone (σs' about 1, σa 0.002 to 0.05), absorbing more towards blue. Sizes and
// setups of the paper's samples: [W] table II. Refractive index 1.3, as in [W], but for the
// homogeneous phantom's 1.4.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session.h"
#include "core/grid.h"

namespace kappamu::synthetic {

/// Coefficients at one point, per channel R, G, B.
struct PointCoefficients {
  std::array<double, 3> scattering{};  ///< reduced scattering σs' [1/mm]
  std::array<double, 3> absorption{};  ///< μ [1/mm]
};

struct SampleModel {
  std::string name;
  GridShape grid;  ///< what a session asks the pipeline to fit
  capture::Setup setup = capture::Setup::back_lit;
  double eta = 1.3;  ///< refractive index relative to air [dimensionless]
  /// Coefficients at a position in the sample frame [mm].
  std::function<PointCoefficients(const Eigen::Vector3d&)> coefficients;

  Face lit_face() const { return Face::z_minus; }
  Face seen_face() const {
    return setup == capture::Setup::back_lit ? Face::z_plus : Face::z_minus;
  }
};

/// demo, wax1, wax2, marble, stone, tiny, phantom.
std::vector<std::string> sample_names();

/// Throws InputError, listing the names, unless `name` is a sample's. `seed` varies the structure;
/// `grid` replaces the sample's own grid (the voxel edge and the structure's size stay) where
/// given.
SampleModel make_sample(const std::string& name, std::uint64_t seed,
                        std::optional<std::array<int, 3>> grid = std::nullopt);

/// κ and μ of the three channels at the cell centres of `shape`, a grid over the same block.
std::array<Medium, 3> sample_medium(const SampleModel& sample, const GridShape& shape);

}  // namespace kappamu::synthetic
