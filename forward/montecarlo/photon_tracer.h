// Photons followed through a block on an OpenCL device, and what they tally; the raw counts behind
// the `montecarlo` forward model. docs/montecarlo.md tells the method.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/grid.h"
#include "core/progress.h"
#include "core/surface_measurements.h"
#include "device/context.h"
#include "forward/grid/block_light.h"
#include "forward/grid/grid_solver.h"
#include "forward/montecarlo/philox.h"

namespace kappamu::forward {

struct TraceOptions {
  std::uint64_t photons = 1'000'000;  ///< per pattern, 2 to 2^32 − 1
  std::uint64_t seed = 1;
  double anisotropy = 0.0;             ///< Henyey-Greenstein g
  std::optional<std::size_t> items{};  ///< work-items per pattern; changes nothing in the tallies
  LightGeometry light{};
  bool fluence = false;  ///< tally PhotonTally::fluence
  Cameras cameras{};     ///< tally PhotonTally::view for these; no points, no boundary source
};

/// Weights of photons and their squares, as integers; sums are exact and independent of order. A
/// photon scores at most once in a pixel, since it leaves once, so that `square` is the second
/// moment per photon.
struct Score {
  static constexpr double full_weight = 0x1p31;  ///< of one photon, in units of `weight`
  static constexpr double full_square = 0x1p32;  ///< its square, in units of `square`
  std::uint64_t weight = 0;
  std::uint64_t square = 0;

  Score& operator+=(const Score& other) {
    weight += other.weight;
    square += other.square;
    return *this;
  }
  /// Mean weight per photon, a full one being 1, of `photons` independent ones.
  double mean(std::uint64_t photons) const;
  /// Standard error of mean(): √((⟨w²⟩ − ⟨w⟩²)/(N−1)).
  double standard_error(std::uint64_t photons) const;
};

struct PatternTotals {
  std::uint64_t absorbed = 0;     ///< weight
  std::uint64_t unscattered = 0;  ///< weight that left by any face without a collision
  std::array<Score, 6> cone;      ///< left within 10° of the face's normal, scattered
};

struct PhotonTally {
  std::uint64_t photons = 0;          ///< per pattern; patterns without light have none
  std::vector<Score> exits;           ///< [pattern][surface pixel], scattered light
  std::vector<PatternTotals> totals;  ///< one per pattern
  /// [pattern][z][y][x] scattered light's fluence rate per power that enters, and its standard
  /// error from ten or more batches of photons [1/mm²]; empty unless asked for.
  std::vector<double> fluence, fluence_error;
  /// [pattern][v][u] of each face with a camera: the weight per photon that would leave by each
  /// pixel if the P1 law (radiance_per_exitance) held for the radiance that the camera sees, and
  /// its standard error from ten or more batches; in order of all_faces, empty without a camera.
  std::array<std::vector<double>, 6> view, view_error;
  double majorant = 0.0;         ///< [1/mm]
  double mean_extinction = 0.0;  ///< [1/mm]
};

/// Surface pixels of the six faces lie one face after the other, in order of all_faces, [v][u].
std::size_t first_pixel(const GridShape& shape, Face face);
std::size_t surface_pixels(const GridShape& shape);

/// Follows `options.photons` photons per pattern from the lit face, where each enters a pixel with
/// the chance its irradiance deserves, transmitted light only: the weight of a pattern's photons
/// together is T Σ E h². `irradiance` is [pattern][v][u]. A point's photons start there, as
/// scattered ones. Equal options give equal bits on one
/// device. Throws InputError for an unphysical medium, options out of range or the wang2008
/// convention, DeviceError when the device fails or draws wrong random numbers.
PhotonTally trace_photons(device::Context& context, const GridSetup& setup, const Medium& medium,
                          std::span<const double> irradiance, int patterns,
                          const TraceOptions& options, Progress& progress);

/// Philox4x32-10 as the device computes it: one block of four numbers per counter.
std::vector<PhiloxBlock> philox_blocks(device::Context& context, std::array<std::uint32_t, 2> key,
                                       std::span<const PhiloxBlock> counters);

}  // namespace kappamu::forward
