// Test media and light for measurements: the same few volumes wherever speed, error or stability is
// charted, so that figures of different tables speak of the same problem. Deterministic: equal
// arguments give equal bits.
#pragma once

#include <string>
#include <vector>

#include "core/grid.h"

namespace kappamu::test_cases {

enum class MediumKind {
  uniform,
  smooth,      ///< one cosine per axis, the same figure on every grid
  inclusions,  ///< balls, every other one conducting, the rest insulating, about 5 across the block
  checkerboard,  ///< cubes of `period` voxels
  layers,        ///< `period` voxels thick, stacked along `axis`
  random,        ///< log-uniform, independent for each cube of `period` voxels
  shell          ///< the outermost voxels against all others: κ jumps next to the boundary
};

/// "uniform", "smooth", ...
std::string to_string(MediumKind kind);

struct MediumSpec {
  MediumKind kind = MediumKind::uniform;
  /// Largest over smallest κ of the kind's figure; balls lie at √contrast times and one
  /// √contrast-th of what surrounds them. Below 1 the figure is inverted (a conducting shell).
  double contrast = 1.0;
  double background_contrast = 1.0;  ///< of a smooth variation that multiplies the figure
  double mean_kappa = 0.3;           ///< geometric mean over the block [mm]
  double mu = 0.01;                  ///< everywhere [1/mm]
  int period = 1;                    ///< [voxels]
  int axis = 2;                      ///< of layers
  unsigned seed = 1;                 ///< of random and of the balls' places
};

/// Throws InputError naming the field unless contrasts, mean_kappa and period are positive, mu is
/// not negative and axis is 0, 1 or 2.
Medium make_medium(const GridShape& shape, const MediumSpec& spec);

/// The medium of the speed comparison: κ of contrast 10 with inclusions at ×100 and ÷100.
MediumSpec reference_inclusions();

/// Irradiance [pattern][v][u] on a face cut into a near-square raster of patches; pattern m lights
/// patch m with irradiance 1, patches no pattern lights stay dark. Where the face has fewer voxels
/// than patches, neighbouring patterns light the same voxel.
std::vector<double> patch_light(const GridShape& shape, Face lit_face, int patterns);

/// The same of `bars` bars across u and then as many across v (capture::LightShape::bars): [2 bars]
/// patterns.
std::vector<double> bar_light(const GridShape& shape, Face lit_face, int bars);

}  // namespace kappamu::test_cases
