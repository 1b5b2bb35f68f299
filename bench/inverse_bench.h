// `kappamu bench inverse`: what fits cost and how good their volumes are. Sections are measured one
// by one, each into a record of its own (inverse-<section>.json); charts, tables and the summary
// are made from whatever records a folder holds.
//
// No fitted discretisation makes its own data: truths are solved on a grid twice as fine, or traced
// by Monte Carlo, and get noise. Volumes are judged as exported: every voxel split in 2³, nothing
// corrected, noise-free truth, light the fit never saw (bench/inverse_case.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kappamu::bench {

enum class BenchSize {
  quick,  ///< seconds on toy grids: shows that it runs, proves nothing
  small,  ///< minutes: smaller blocks, fewer truths
  full
};

struct InverseBenchOptions {
  std::filesystem::path folder;
  std::string device = "auto";
  BenchSize size = BenchSize::full;
  std::uint64_t seed = 1;  ///< of truths and noise
  /// Of section samples: those to measure, all where empty; the record keeps the others' rows.
  std::vector<std::string> samples;
};

/// In the order they are measured:
///   optimisers  E along the course of every way to fit, noise 0, 0.3, 1, 3 %
///   scores      the default over several truths and seeds, noise 0.3, 1, 3 %; error by depth
///   embedded    the same of smaller boxes within the block (TruthSpec::embedded)
///   patterns    E against the number of images: n × n patches, n = 1 to 8 ([W] figure 11), and
///               bars, back-lit and front-lit
///   voxels      time and solves against the number of voxels
///   montecarlo  data by Monte Carlo transport instead of diffusion
///   samples     [W] Table II at full size: from measurements to volumes, R, G and B
const std::vector<std::string>& inverse_sections();

/// Measures one section and writes its record. Throws InputError for an unknown section.
void measure_inverse(const std::string& section, const InverseBenchOptions& options,
                     Progress& progress);

/// Draws bench-inverse-<section>.png and writes table-inverse-<section>.md for every record in the
/// folder.
void draw_inverse(const std::filesystem::path& folder);

/// What `--json` prints, of the default at 1 % noise: sample, grid, channels, patterns, noise,
/// optimiser, batched_solves, seconds, holdout_E, data_misfit_chi2, device. Throws InputError
/// without a record of section scores or optimisers.
nlohmann::ordered_json inverse_summary(const std::filesystem::path& folder);

}  // namespace kappamu::bench
