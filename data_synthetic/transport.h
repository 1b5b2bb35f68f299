// Light through the simulated block: the grid solver on cells finer than those a pipeline fits, or
// Monte Carlo transport through the same cells.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/grid.h"
#include "core/optics.h"
#include "core/surface_measurements.h"

namespace kappamu::synthetic {

/// The geometry and physics of a block: physical convention, first-collision source.
struct Block {
  GridShape shape;
  double eta = 1.3;
  Face lit_face = Face::z_minus;
  Sides sides = Sides::open;
};

enum class TransportMethod {
  diffusion,   ///< grid diffusion, converged: no noise, but the pipeline's own physics
  monte_carlo  ///< radiative transfer, scattering of σs' isotropic or by g: noisy, more than
               ///< diffusion
};

/// How a block's light is computed; the defaults are those of a simulation.
struct TransportChoice {
  TransportMethod method = TransportMethod::diffusion;
  std::uint64_t photons = 300'000;  ///< per pattern, Monte Carlo
  std::uint64_t seed = 1;           ///< of Monte Carlo; every call draws streams of its own
  double anisotropy = 0.0;          ///< Henyey-Greenstein g of Monte Carlo, σs = σs'/(1 − g)
};

/// Exitance of a block under any light; keeps its solver from one medium to the next. Patterns are
/// solved in batches of up to 16, fewer where memory is short (about 8 GB at most).
class Transport {
 public:
  /// Throws InputError when no device matches; Monte Carlo needs an OpenCL device.
  Transport(const Block& block, const std::string& device, const TransportChoice& choice = {});
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  void set_medium(const Medium& medium);

  /// Exitance [pattern][v][u] of `face` for incident irradiance [pattern][v][u] on the lit face,
  /// unscattered light apart. `progress` hears the finished fraction. Throws InputError when a
  /// solve does not converge.
  std::vector<double> exitance(std::span<const double> irradiance, Face face,
                               const std::function<void(double)>& progress = {}) const;

  const Block& block() const { return block_; }
  const BoundaryConstants& constants() const;
  std::string backend() const;
  /// The physics in a few words, for reports: "grid diffusion, ...".
  std::string model() const;
  /// Empty, or what the user should know about the device.
  const std::string& warning() const { return warning_; }

 private:
  struct Solver;
  std::vector<double> diffuse(std::span<const double> irradiance, Face face, int count) const;
  std::vector<double> trace(std::span<const double> irradiance, Face face, int count) const;

  Block block_;
  TransportChoice choice_;
  std::unique_ptr<Solver> solver_;
  std::string warning_;
};

/// Irradiance of n × n even patches that tile the lit face, one pattern per patch in rows of u:
/// [n²][v][u], 1 on the cells of the patch (fractions where its edge divides a cell).
std::vector<double> patch_irradiance(const FaceShape& face, int n);

/// Surface maps [pattern][v][u] averaged over blocks of factor × factor cells.
std::vector<double> average_cells(std::span<const double> maps, const FaceShape& fine, int factor);

/// Surface maps [pattern][v][u] with every cell split factor × factor times, values kept.
std::vector<double> split_cells(std::span<const double> maps, const FaceShape& coarse, int factor);

/// The same for a volume.
Volume<double> split_cells(const Volume<double>& coarse, int factor);

}  // namespace kappamu::synthetic
