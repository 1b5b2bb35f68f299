// `kappamu bench forward`: time against true error of every method, its growth with the grid, the
// peers, and iterations against contrast. Sections are measured one by one, each into a record of
// its own (forward-<section>.json), so that a busy machine's can be repeated alone; charts, tables
// and the summary are made from whatever records a folder holds.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kappamu::bench {

struct ForwardBenchOptions {
  std::filesystem::path folder;
  std::string device = "auto";
  bool quick = false;   ///< small grids, seconds in all: shows that it runs, proves nothing
  int repetitions = 3;  ///< medians are taken over these
  bool peers = true;    ///< those that are built
};

/// In the order they are measured:
///   headline    every method on 256×256×20, 16 patterns, κ contrast 10 with inclusions ×100, ÷100
///   peers       hypre, PETSc, Eigen on the same problem, beside a fresh measurement of ours
///   kernels     what share of the bandwidth each kernel of our solve uses on that problem
///   relaxation  how far the papers' relaxation is from 1e-2 after a minute on that problem
///   grids       every method on other grids and contrasts
///   scaling     ours and hypre PFMG from 32³ to 256³
///   iterations  contrast 1 to 10⁶, four figures of κ, grids of 32³ to 256³
const std::vector<std::string>& forward_sections();

/// Measures one section and writes its record. Throws InputError for an unknown section.
void measure_forward(const std::string& section, const ForwardBenchOptions& options,
                     Progress& progress);

/// Draws bench-<section>.png and writes table-<name>.md for every record in the folder.
void draw_forward(const std::filesystem::path& folder);

/// What `--json` prints, from the record of section peers where there is one, else of headline:
/// grid, patterns, contrast, method, precision, iterations, seconds_per_rhs, true_error,
/// bandwidth_fraction, and `peers`, each the same with `ratio`, the fastest of other people's
/// named; `relaxation` and `kernels` from the records of these sections. Without either, these two
/// and the names of the sections there are. Throws InputError where there is none.
nlohmann::ordered_json forward_summary(const std::filesystem::path& folder);

}  // namespace kappamu::bench
