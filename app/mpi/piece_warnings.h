// What forward/diffusion_warnings.h says of a block that no rank holds whole.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "forward/distributed/block_pieces.h"

namespace kappamu::app::mpi {

/// `kappa` and `mu` of the piece, or their logarithms. The sentences tell means and shares, which
/// some 100 000 voxels evenly spread suffice for. On the first rank; none on the others. Called by
/// all.
std::vector<std::string> piece_warnings(const forward::distributed::BlockPieces& pieces,
                                        std::span<const double> kappa, std::span<const double> mu,
                                        bool logarithms = false);

}  // namespace kappamu::app::mpi
