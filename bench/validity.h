// Where diffusion can be trusted: its error against Monte Carlo transport over albedo and optical
// thickness, on slabs under patch light.
//
// Each case is a slab of index 1.3 and transport mean free path 1 mm (κ = 1/3 mm, μ = 1 − albedo
// per mm, isotropic scattering), three thicknesses wide with mirror sides, lit by a collimated beam
// on a square as wide as the slab is thick, seen in pixels of an eighth of that. Diffusion is the
// closed form (forward/analytic/layered_block.h) with the first-collision source and exact A, so no
// grid's error enters. Diffuse light only: what crosses unscattered is left out on both sides.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kappamu::bench {

/// One error of diffusion and what Monte Carlo's noise leaves of it, both relative.
struct RelativeError {
  double value = 0.0;  ///< diffusion / Monte Carlo − 1, or ‖difference‖/‖Monte Carlo‖
  double standard_error = 0.0;  ///< of `value`
  /// Noise is a third of the error at most, or half a percent.
  bool resolved() const;
};

struct ValidityCase {
  double albedo = 0.0;                            ///< σs'/(σs' + μ)
  double mean_free_paths = 0.0;                   ///< thickness × (σs' + μ)
  RelativeError reflected, transmitted;           ///< totals, signed
  RelativeError lit_map, far_map;                 ///< pixel maps, relative L2 less the noise's part
  double reflectance = 0.0, transmittance = 0.0;  ///< Monte Carlo's, of the incident power
};

struct ValidityOptions {
  std::vector<double> albedos{0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999};
  std::vector<double> thicknesses{1, 2, 4, 8, 16, 32, 50};  ///< mean free paths
  std::uint64_t photons = 1'000'000;                        ///< per case
  std::uint64_t seed = 1;
  std::string device = "auto";
};
/// A few seconds' worth: fewer cases and photons.
ValidityOptions quick_validity();

/// [albedo][thickness], albedo outermost.
std::vector<ValidityCase> measure_validity(const ValidityOptions& options, Progress& progress);

nlohmann::ordered_json validity_record(const ValidityOptions& options,
                                       const std::vector<ValidityCase>& cases);

/// Four tables coloured by |error|: reflected and transmitted totals, lit and far face's maps.
void draw_validity(const std::vector<ValidityCase>& cases, const std::filesystem::path& png);

/// forward/analytic/validity_table.inc: what diffusion_validity() interpolates.
std::string validity_table(const ValidityOptions& options, const std::vector<ValidityCase>& cases);

}  // namespace kappamu::bench
