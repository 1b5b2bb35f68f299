// Runs hypre's PFMG (studies/peers) on our problem, in processes of its own under mpirun.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "studies/forward/measure.h"

namespace kappamu::studies {

inline constexpr const char* peer_name = "hypre-pfmg";

/// Whether this program was built beside it and there is an mpirun.
bool has_peer();

struct PeerRun {
  std::string setting;  ///< the fastest of its settings on the first pattern at residual 1e-6
  int ranks = 0;
  std::vector<std::string> trials;  ///< "setting: seconds, iterations" of all that were tried
  std::vector<Sample> samples;      ///< one per tolerance; method is the peer's name
};

/// Solves the first `patterns` of the problem. Times leave out the assembly of the peer's matrix;
/// the set-up of its preconditioner is shared by the problem's patterns, as ours is. Throws
/// InputError with the peer's last words when it fails. `folder` holds the exchange and is emptied.
PeerRun run_peer(const Problem& problem, int patterns, const std::vector<double>& tolerances,
                 int repetitions, const std::filesystem::path& folder);

}  // namespace kappamu::studies
