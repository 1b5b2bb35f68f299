#include "app/mpi/piece_warnings.h"

#include <array>
#include <cmath>

#include "forward/diffusion_warnings.h"

namespace kappamu::app::mpi {

namespace {

using forward::distributed::BlockPieces;

/// κ and μ of the voxels whose numbers along each axis are multiples of `every`.
std::vector<double> own_sample(const BlockPieces& pieces, std::span<const double> kappa,
                               std::span<const double> mu, std::size_t every) {
  const GridShape& piece = pieces.piece().shape;
  const auto nx = static_cast<std::size_t>(piece.nx), ny = static_cast<std::size_t>(piece.ny);
  const auto& first = pieces.held().begin;
  std::vector<double> own;
  pieces.for_own([&](std::size_t i, std::size_t) {
    const std::array<std::size_t, 3> at{i % nx + first[0], i / nx % ny + first[1],
                                        i / nx / ny + first[2]};
    for (const std::size_t x : at) {
      if (x % every != 0) return;
    }
    own.insert(own.end(), {kappa[i], mu[i]});
  });
  return own;
}

}  // namespace

std::vector<std::string> piece_warnings(const BlockPieces& pieces, std::span<const double> kappa,
                                        std::span<const double> mu, bool logarithms) {
  constexpr double most = 1e5;
  const GridShape& whole = pieces.whole().shape;
  const auto every =
      static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(whole.cells()) / most)));
  const std::vector<double> own = own_sample(pieces, kappa, mu, every);
  const int count = static_cast<int>(own.size());
  std::vector<int> counts(static_cast<std::size_t>(pieces.ranks())), begins(counts.size(), 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, pieces.comm());
  for (std::size_t r = 1; r < counts.size(); ++r) begins[r] = begins[r - 1] + counts[r - 1];
  std::vector<double> all(static_cast<std::size_t>(begins.back() + counts.back()));
  MPI_Gatherv(own.data(), count, MPI_DOUBLE, all.data(), counts.data(), begins.data(), MPI_DOUBLE,
              0, pieces.comm());
  if (pieces.rank() != 0) return {};
  const GridShape line{static_cast<int>(all.size() / 2), 1, 1, whole.voxel_mm};
  Medium sample{Volume<double>(line), Volume<double>(line)};
  for (std::size_t i = 0; i < line.cells(); ++i) {
    sample.kappa[i] = logarithms ? std::exp(all[2 * i]) : all[2 * i];
    sample.mu[i] = logarithms ? std::exp(all[2 * i + 1]) : all[2 * i + 1];
  }
  return forward::diffusion_warnings(pieces.whole(), sample, forward::Precision::double_precision);
}

}  // namespace kappamu::app::mpi
