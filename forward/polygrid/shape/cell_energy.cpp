#include "forward/polygrid/shape/cell_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/numbers/at.h"
#include "core/numbers/widest.h"
#include "core/parallel.h"

namespace kappamu::forward {

using Eigen::Vector3d;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::size_t cells_of_piece = 1024;

/// The eight corners of a cell, in the order of their bits.
typedef double Eight __attribute__((vector_size(8 * sizeof(double))));            // NOLINT
typedef std::int64_t EightBits __attribute__((vector_size(8 * sizeof(double))));  // NOLINT

/// Sum over some cells, and each one's slopes.
KAPPAMU_WIDEST double energy_of_some(const CellEnergy& energy, const std::array<int, 8>* cells,
                                     const TargetCell* targets, std::size_t count,
                                     const Vector3d* corner, CellEnergies::Slopes* slopes) {
  Eight total{};
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::array<double, 8>, 3> places;
    for (std::size_t b = 0; b < 8; ++b) {
      const Vector3d& place = corner[cells[i][b]];
      for (std::size_t d = 0; d < 3; ++d) places[d][b] = place[static_cast<Eigen::Index>(d)];
    }
    Eight x[3];
    std::memcpy(x, places.data(), sizeof x);
    // The edges at every corner over those of the target, the columns of J: the same at both ends.
    const double along_x = targets[i].inverse_edge[0], along_y = targets[i].inverse_edge[1],
                 along_z = targets[i].inverse_edge[2];
    Eight u[3], v[3], w[3];
    for (int d = 0; d < 3; ++d) {
      u[d] = along_x * (__builtin_shufflevector(x[d], x[d], 1, 1, 3, 3, 5, 5, 7, 7) -
                        __builtin_shufflevector(x[d], x[d], 0, 0, 2, 2, 4, 4, 6, 6));
      v[d] = along_y * (__builtin_shufflevector(x[d], x[d], 2, 3, 2, 3, 6, 7, 6, 7) -
                        __builtin_shufflevector(x[d], x[d], 0, 1, 0, 1, 4, 5, 4, 5));
      w[d] = along_z * (__builtin_shufflevector(x[d], x[d], 4, 5, 6, 7, 4, 5, 6, 7) -
                        __builtin_shufflevector(x[d], x[d], 0, 1, 2, 3, 0, 1, 2, 3));
    }
    Eight vw[3], wu[3], uv[3], squares{}, det{};
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      vw[d] = v[e] * w[f] - v[f] * w[e];
      wu[d] = w[e] * u[f] - w[f] * u[e];
      uv[d] = u[e] * v[f] - u[f] * v[e];
      squares += u[d] * u[d] + v[d] * v[d] + w[d] * w[d];
      det += u[d] * vw[d];
    }
    // Square roots by Newton's method for 1/√a.
    const Eight s = squares * (1.0 / 3.0),
                under[2] = {s, energy.epsilon * energy.epsilon + det * det};
    Eight roots[2];
    for (int k = 0; k < 2; ++k) {
      EightBits bits;
      std::memcpy(&bits, &under[k], sizeof bits);
      bits = 0x5fe6eb50c7b537a9 - (bits >> 1);
      Eight inverse;
      std::memcpy(&inverse, &bits, sizeof inverse);
      for (int step = 0; step < 4; ++step) {
        inverse *= 1.5 - 0.5 * under[k] * inverse * inverse;
      }
      roots[k] = under[k] * inverse;
    }
    const Eight chi = 0.5 * (det + roots[1]), inverse_chi = 1.0 / chi;
    for (int b = 0; b < 8; ++b) {
      if (!(chi[b] > 0.0) || (energy.epsilon == 0.0 && !(det[b] > 0.0))) return infinite;
    }
    const Eight shape = s * roots[0] * inverse_chi, size = 0.5 * (det * det + 1.0) * inverse_chi;
    const Eight of_corner = shape + energy.size_weight * size;
    Eight outer = Eight{} + 1.0, raised = of_corner;
    for (int k = 1; k < energy.power; ++k) {
      outer = static_cast<double>(k + 1) * raised;
      raised *= of_corner;
    }
    total += raised;
    // d shape/ds per column (s is a third of |J|²), and d energy/d det.
    const Eight by_s = outer * roots[0] * inverse_chi;
    const Eight by_det = outer * (energy.size_weight * det * inverse_chi -
                                  (shape + energy.size_weight * size) / roots[1]);
    for (int d = 0; d < 3; ++d) {
      const Eight fu = along_x * (by_s * u[d] + by_det * vw[d]),
                  fv = along_y * (by_s * v[d] + by_det * wu[d]),
                  fw = along_z * (by_s * w[d] + by_det * uv[d]);
      // Of both ends' energies, against the edge at its first end.
      const Eight on_u = fu + __builtin_shufflevector(fu, fu, 1, 0, 3, 2, 5, 4, 7, 6),
                  on_v = fv + __builtin_shufflevector(fv, fv, 2, 3, 0, 1, 6, 7, 4, 5),
                  on_w = fw + __builtin_shufflevector(fw, fw, 4, 5, 6, 7, 0, 1, 2, 3);
      const Eight sign_u{-1, 1, -1, 1, -1, 1, -1, 1}, sign_v{-1, -1, 1, 1, -1, -1, 1, 1},
          sign_w{-1, -1, -1, -1, 1, 1, 1, 1};
      const Eight slope = sign_u * on_u + sign_v * on_v + sign_w * on_w;
      std::memcpy(slopes[i][static_cast<std::size_t>(d)].data(), &slope, sizeof slope);
    }
  }
  double sum = 0.0;
  for (int b = 0; b < 8; ++b) sum += total[b];
  return sum;
}

}  // namespace

CellEnergies::CellEnergies(const std::vector<std::array<int, 8>>& cells,
                           const std::vector<TargetCell>& targets, std::size_t corners)
    : cells_(cells),
      targets_(targets),
      slot_start_(corners + 1, 0),
      slot_(8 * cells.size()),
      slopes_(cells.size()) {
  for (const auto& cell : cells) {
    for (const int c : cell) ++slot_start_[at(c) + 1];
  }
  for (std::size_t c = 0; c < corners; ++c) slot_start_[c + 1] += slot_start_[c];
  std::vector<int> next(slot_start_.begin(), slot_start_.end() - 1);
  for (std::size_t i = 0; i < 8 * cells.size(); ++i) {
    slot_[at(next[at(cells[i / 8][i % 8])]++)] = static_cast<int>(i);
  }
}

double CellEnergies::operator()(const CellEnergy& energy, const std::vector<Vector3d>& corner,
                                std::vector<Vector3d>& gradient) {
  std::vector<double> of_piece(pieces(cells_.size(), cells_of_piece), 0.0);
  for_pieces(cells_.size(), cells_of_piece,
             [&](std::size_t piece, std::size_t begin, std::size_t end) {
               of_piece[piece] = energy_of_some(energy, &cells_[begin], &targets_[begin],
                                                end - begin, corner.data(), &slopes_[begin]);
             });
  double total = 0.0;
  for (const double some : of_piece) total += some;
  if (!std::isfinite(total)) return infinite;
  gradient.resize(corner.size());
  for_pieces(corner.size(), cells_of_piece, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      gradient[c].setZero();
      for (int s = slot_start_[c]; s < slot_start_[c + 1]; ++s) {
        const std::size_t cell = at(slot_[at(s)]) / 8, b = at(slot_[at(s)]) % 8;
        const Slopes& slopes = slopes_[cell];
        gradient[c] += Vector3d(slopes[0][b], slopes[1][b], slopes[2][b]);
      }
    }
  });
  return total;
}

double CellEnergies::least_determinant(const std::vector<Vector3d>& corner) const {
  std::vector<double> of_piece(pieces(cells_.size(), cells_of_piece), infinite);
  for_pieces(
      cells_.size(), cells_of_piece, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const auto x = [&](unsigned b) -> const Vector3d& { return corner[at(cells_[i][b])]; };
          for (unsigned b = 0; b < 8; ++b) {
            const double d = (x(b | 1U) - x(b & ~1U))
                                 .dot((x(b | 2U) - x(b & ~2U)).cross(x(b | 4U) - x(b & ~4U)));
            of_piece[piece] = std::min(of_piece[piece], d * targets_[i].inverse_edge.prod());
          }
        }
      });
  double least = infinite;
  for (const double some : of_piece) least = std::min(least, some);
  return least;
}

}  // namespace kappamu::forward
