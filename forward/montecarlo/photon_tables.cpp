#include "forward/montecarlo/photon_tables.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::forward {

namespace {

/// Coefficients stored as float may say σs' = −1e-7 σt' where zero was meant.
constexpr double rounding = 1e-6;

/// Mean free paths along the block's longest edge: with a million photons that takes hours, and
/// beyond the program would seem to hang.
constexpr double most_collisions = 1e6;

std::uint32_t chance(double probability) {
  return static_cast<std::uint32_t>(std::min(std::round(probability * 0x1p32), 0x1p32 - 1.0));
}

std::string voxel_name(const GridShape& shape, std::size_t i) {
  const auto nx = static_cast<std::size_t>(shape.nx), ny = static_cast<std::size_t>(shape.ny);
  return "(x, y, z) = (" + std::to_string(i % nx) + ", " + std::to_string(i / nx % ny) + ", " +
         std::to_string(i / (nx * ny)) + ")";
}

}  // namespace

CollisionTable collision_table(const Medium& medium, double anisotropy) {
  if (!(anisotropy > -1.0 && anisotropy < 1.0)) {
    throw InputError("anisotropy g is " + std::to_string(anisotropy) +
                     "; choose a value between -1 and 1, both excluded");
  }
  const std::size_t cells = medium.kappa.size();
  std::vector<double> extinction(cells);
  for (std::size_t i = 0; i < cells; ++i) {
    const double reduced = 1.0 / (3.0 * medium.kappa[i]);
    const double scattering = reduced - medium.mu[i];
    if (scattering < -rounding * reduced) {
      throw InputError("medium: at voxel " + voxel_name(medium.kappa.shape(), i) +
                       " kappa = " + std::to_string(medium.kappa[i]) +
                       " and mu = " + std::to_string(medium.mu[i]) +
                       " leave no scattering (3 kappa mu > 1), which Monte Carlo transport cannot "
                       "read as a medium; lower kappa or mu there");
    }
    extinction[i] = medium.mu[i] + std::max(0.0, scattering) / (1.0 - anisotropy);
  }
  CollisionTable table;
  table.majorant = *std::max_element(extinction.begin(), extinction.end());
  const GridShape& shape = medium.kappa.shape();
  const double longest = shape.voxel_mm * std::max({shape.nx, shape.ny, shape.nz});
  if (table.majorant * longest > most_collisions) {
    throw InputError(
        formatted("medium: at its densest voxel light scatters every %.3g mm, a photon some %.2g "
                  "times; Monte Carlo transport follows at most %.0g, choose a model of diffusion",
                  1.0 / table.majorant, table.majorant * longest, most_collisions));
  }
  table.mean =
      std::accumulate(extinction.begin(), extinction.end(), 0.0) / static_cast<double>(cells);
  table.voxels.resize(cells);
  for (std::size_t i = 0; i < cells; ++i) {
    table.voxels[i] = {chance(extinction[i] / table.majorant),
                       chance(medium.mu[i] / extinction[i])};
  }
  return table;
}

std::vector<AliasEntry> alias_table(std::span<const double> weights) {
  const std::size_t n = weights.size();
  const double mean = std::accumulate(weights.begin(), weights.end(), 0.0) / static_cast<double>(n);
  check(mean > 0.0, "alias_table: some weight is positive");
  std::vector<double> level(n);
  std::vector<std::size_t> below, above;
  for (std::size_t i = 0; i < n; ++i) {
    level[i] = weights[i] / mean;
    (level[i] < 1.0 ? below : above).push_back(i);
  }
  std::vector<AliasEntry> table(n);
  for (std::size_t i = 0; i < n; ++i) table[i].other = static_cast<std::uint32_t>(i);
  // Each low pixel is filled up to the mean from one that has more.
  while (!below.empty() && !above.empty()) {
    const std::size_t low = below.back();
    below.pop_back();
    const std::size_t high = above.back();
    table[low] = {chance(level[low]), static_cast<std::uint32_t>(high)};
    level[high] -= 1.0 - level[low];
    if (level[high] < 1.0) {
      above.pop_back();
      below.push_back(high);
    }
  }
  // What is left over equals the mean up to rounding; an empty pixel is never left over, since the
  // full ones hold its share.
  return table;
}

}  // namespace kappamu::forward
