#include "inverse/distributed/piece_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "forward/distributed/plane_exchange.h"
#include "forward/distributed/together.h"
#include "inverse/defaults.h"

namespace kappamu::inverse::distributed {

namespace {

using forward::GridSetup;
using forward::distributed::Box;

/// f(pixel of the piece's maps [v][u], u and v in the whole face), of the rank's own pixels.
template <class F>
void for_own_pixels(const BlockPieces& pieces, Face face, F f) {
  const FaceShape shape = face_shape(pieces.piece().shape, face);
  const auto [u_axis, v_axis] = face_axes(face);
  const auto& first = pieces.held().begin;
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      if (!pieces.owns_pixel(face, u, v)) continue;
      f(static_cast<std::size_t>(v) * shape.nu + u, u + first[u_axis], v + first[v_axis]);
    }
  }
}

/// Adds the error that is a share of each pattern's largest datum, wherever that lies.
void add_share_of_maximum(const BlockPieces& pieces, double share, Problem& problem) {
  const std::size_t pixels = problem.seen_shape().cells();
  std::vector<double> largest(static_cast<std::size_t>(problem.patterns), 0.0);
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] > 0.0) {
      largest[i / pixels] = std::max(largest[i / pixels], std::abs(problem.data[i]));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX,
                pieces.comm());
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    problem.weight[i] = 1.0 / (1.0 / problem.weight[i] + std::pow(share * largest[i / pixels], 2));
  }
}

/// The whole problem, averaged over factor × factor pixels.
Problem averaged(const BlockPieces& pieces, const Problem& problem, int factor) {
  const GridShape& s = pieces.whole().shape;
  const auto coarse = [&](int n) { return (n + factor - 1) / factor; };
  Problem whole;
  whole.setup = pieces.whole();
  whole.setup.shape = {coarse(s.nx), coarse(s.ny), coarse(s.nz), factor * s.voxel_mm};
  whole.seen_face = problem.seen_face;
  whole.patterns = problem.patterns;
  const FaceShape lit = whole.lit_shape(), seen = whole.seen_shape();
  const auto patterns = static_cast<std::size_t>(problem.patterns);
  whole.irradiance.assign(patterns * lit.cells(), 0.0);
  whole.data.assign(patterns * seen.cells(), 0.0);
  whole.weight = whole.data;
  std::vector<double> variance = whole.data, present = whole.data, covered = whole.data;
  for (std::size_t m = 0; m < patterns; ++m) {
    for_own_pixels(pieces, whole.setup.lit_face, [&](std::size_t k, int u, int v) {
      whole.irradiance[m * lit.cells() + static_cast<std::size_t>(v / factor) * lit.nu +
                       u / factor] +=
          problem.irradiance[m * problem.lit_shape().cells() + k] / (factor * factor);
    });
    for_own_pixels(pieces, problem.seen_face, [&](std::size_t k, int u, int v) {
      const std::size_t from = m * problem.seen_shape().cells() + k;
      const std::size_t to =
          m * seen.cells() + static_cast<std::size_t>(v / factor) * seen.nu + u / factor;
      covered[to] += 1.0;
      if (problem.weight[from] == 0.0) return;
      present[to] += 1.0;
      whole.data[to] += problem.data[from];
      variance[to] += 1.0 / problem.weight[from];
    });
  }
  for (std::vector<double>* sums : {&whole.irradiance, &whole.data, &variance, &present, &covered})
    pieces.sum(*sums);
  for (std::size_t i = 0; i < whole.data.size(); ++i) {
    const bool all = present[i] > 0.0 && present[i] == covered[i];
    whole.data[i] = all ? whole.data[i] / present[i] : 0.0;
    whole.weight[i] = all ? present[i] * present[i] / variance[i] : 0.0;
  }
  return whole;
}

/// Maps [M][v][u] of a face of one box made those of another; `from` and `to` are the pieces' held
/// or owned boxes of the same grid, the pixels the rank's own.
std::vector<double> own_maps(const BlockPieces& pieces, Face face, int patterns,
                             const std::vector<double>& maps, const Box& from, const Box& to) {
  const auto [u_axis, v_axis] = face_axes(face);
  const auto place = [&, u = u_axis, v = v_axis](const Box& box, int m, int at_u, int at_v) {
    return (static_cast<std::size_t>(m) * box.extent(v) + (at_v - box.begin[v])) * box.extent(u) +
           (at_u - box.begin[u]);
  };
  std::vector<double> result(
      static_cast<std::size_t>(patterns) * to.extent(u_axis) * to.extent(v_axis), 0.0);
  for (int m = 0; m < patterns; ++m) {
    for_own_pixels(pieces, face, [&](std::size_t, int u, int v) {
      result[place(to, m, u, v)] = maps[place(from, m, u, v)];
    });
  }
  return result;
}

/// Maps of a face of which each rank has its own pixels.
class PieceMaps final : public SharedMaps {
 public:
  PieceMaps(const BlockPieces& pieces, Face face, int patterns)
      : comm_(pieces.comm()), planes_(exchange(pieces, face, patterns)) {
    const FaceShape shape = face_shape(pieces.piece().shape, face);
    for (int m = 0; m < patterns; ++m) {
      for_own_pixels(pieces, face, [&](std::size_t k, int, int) {
        own_.push_back(static_cast<std::size_t>(m) * shape.cells() + k);
      });
    }
  }

  std::vector<double> whole(const std::vector<double>& part) const override {
    std::vector<double> packed(own_.size());
    for (std::size_t k = 0; k < own_.size(); ++k) packed[k] = part[own_[k]];
    return planes_.whole(packed);
  }
  void take_part(const std::vector<double>& whole, std::vector<double>& part) const override {
    const std::vector<double> packed = planes_.parts(whole);
    std::fill(part.begin(), part.end(), 0.0);
    for (std::size_t k = 0; k < own_.size(); ++k) part[own_[k]] = packed[k];
  }
  void sum(Eigen::MatrixXd& image) const override {
    MPI_Allreduce(MPI_IN_PLACE, image.data(), static_cast<int>(image.size()), MPI_DOUBLE, MPI_SUM,
                  comm_);
  }

 private:
  static forward::distributed::PlaneExchange exchange(const BlockPieces& pieces, Face face,
                                                      int patterns) {
    const FaceShape whole = face_shape(pieces.whole().shape, face);
    forward::distributed::Rectangle own{{whole.nu, whole.nv}, {0, 0}};
    for_own_pixels(pieces, face, [&](std::size_t, int u, int v) {
      own.begin = {std::min(own.begin[0], u), std::min(own.begin[1], v)};
      own.end = {std::max(own.end[0], u + 1), std::max(own.end[1], v + 1)};
    });
    if (own.pixels() == 0) own = {};
    return {pieces.comm(), own, whole.nu, whole.nv, patterns};
  }

  MPI_Comm comm_;
  std::vector<std::size_t> own_;  ///< pixels of all patterns in the piece's maps
  forward::distributed::PlaneExchange planes_;
};

/// As coarsen() and make_problem() do for a whole block.
void share_errors(const BlockPieces& pieces, const SmoothError& error, Problem& problem) {
  problem.smooth_error = error;
  problem.precision.reset();
  if (error.none()) return;
  double squares = 0.0;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    squares += problem.weight[i] * problem.data[i] * problem.data[i];
  }
  const double used = pieces.sum(static_cast<double>(problem.used()));
  const double signal = std::sqrt(pieces.sum(squares) / std::max(1.0, used));
  problem.precision.emplace(
      face_shape(pieces.whole().shape, problem.seen_face), problem.patterns, signal, error,
      std::make_shared<PieceMaps>(pieces, problem.seen_face, problem.patterns));
}

/// The problem of the rank's own box alone, or back with a halo of nothing.
Problem boxed(const BlockPieces& pieces, const Problem& problem, const Box& from, const Box& to) {
  Problem result = problem;
  result.smooth_error = {};
  result.precision.reset();
  GridShape& shape = result.setup.shape;
  shape = {to.extent(0), to.extent(1), to.extent(2), shape.voxel_mm};
  const auto move = [&](Face face, std::vector<double>& maps) {
    maps = own_maps(pieces, face, problem.patterns, maps, from, to);
  };
  move(problem.setup.lit_face, result.irradiance);
  move(problem.seen_face, result.data);
  move(problem.seen_face, result.weight);
  return result;
}

}  // namespace

Problem piece_problem(const BlockPieces& pieces, const SurfaceMeasurements& measured,
                      forward::Convention convention, const ModelError& error) {
  Problem problem = make_problem(measured, 0, convention, {error.relative, 0.0});
  const auto own = [&](Face face, std::vector<double>& maps) {
    std::vector<double> kept(maps.size(), 0.0);
    const std::size_t pixels = face_shape(problem.setup.shape, face).cells();
    for (std::size_t begin = 0; begin < maps.size(); begin += pixels) {
      for_own_pixels(pieces, face,
                     [&](std::size_t k, int, int) { kept[begin + k] = maps[begin + k]; });
    }
    maps = std::move(kept);
  };
  own(problem.setup.lit_face, problem.irradiance);
  own(problem.seen_face, problem.weight);
  add_share_of_maximum(pieces, error.of_maximum, problem);
  share_errors(pieces, measured.smooth_error, problem);
  return problem;
}

PieceGrid select_patterns(const PieceGrid& all, std::span<const int> patterns) {
  const Problem& problem = all.problem;
  PieceGrid selected = all;
  selected.problem.patterns = static_cast<int>(patterns.size());
  const auto choose = [&](std::vector<double>& maps, std::size_t pixels) {
    std::vector<double> kept;
    for (const int m : patterns) {
      const auto first = maps.begin() + static_cast<std::ptrdiff_t>(pixels) * m;
      kept.insert(kept.end(), first, first + static_cast<std::ptrdiff_t>(pixels));
    }
    maps = std::move(kept);
  };
  choose(selected.problem.irradiance, problem.lit_shape().cells());
  choose(selected.problem.data, problem.seen_shape().cells());
  choose(selected.problem.weight, problem.seen_shape().cells());
  share_errors(*all.pieces, problem.smooth_error, selected.problem);
  return selected;
}

double signal_square(const PieceGrid& grid) {
  const Problem& problem = grid.problem;
  double squares = 0.0;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    squares += problem.weight[i] * problem.data[i] * problem.data[i];
  }
  return grid.pieces->sum(squares);
}

namespace {

PieceGrid coarser_grid(const PieceGrid& fine, const ModelError& error) {
  const auto& [pieces, problem] = fine;
  const std::shared_ptr<const BlockPieces> coarser = pieces->coarser();
  const Problem own =
      coarsen(boxed(*pieces, problem, pieces->held(), pieces->owned()), {error.relative, 0.0});
  PieceGrid coarse{coarser, boxed(*coarser, own, coarser->owned(), coarser->held())};
  add_share_of_maximum(*coarser, error.of_maximum, coarse.problem);
  share_errors(*coarser, problem.smooth_error, coarse.problem);
  return coarse;
}

}  // namespace

std::vector<PieceGrid> piece_levels(PieceGrid finest, const ModelError& coarse_model_error,
                                    int most) {
  using namespace defaults::grid_levels;
  std::vector<PieceGrid> levels;
  levels.push_back(std::move(finest));
  while (static_cast<int>(levels.size()) < most) {
    const BlockPieces& pieces = *levels.back().pieces;
    const GridShape& s = pieces.whole().shape;
    if (pieces.halvings() == 0 || std::min({s.nx, s.ny, s.nz}) < 2 * fewest_voxels) break;
    PieceGrid coarse = coarser_grid(levels.back(), coarse_model_error);
    if (pieces.sum(static_cast<double>(coarse.problem.used())) < fewest_data) break;
    levels.push_back(std::move(coarse));
  }
  return levels;
}

std::optional<PieceGrid> closer_of(const std::vector<PieceGrid>& levels,
                                   const ModelError& coarse_model_error) {
  using namespace defaults::grid_levels;
  const auto& [relative, of_maximum] = coarse_model_error;
  if (levels.size() <= 2 || levels.front().problem.smooth_error.none() ||
      relative + of_maximum == 0.0) {
    return std::nullopt;
  }
  return coarser_grid(levels.front(), {closer_share * relative, closer_share * of_maximum});
}

PieceRefinement piece_refinement(const PieceGrid& coarse, const PieceGrid* finer) {
  PieceRefinement result;
  if (finer == nullptr) {
    result.refinement = refine(coarse.problem);
    GridSetup whole = coarse.pieces->whole();
    whole.shape = whole.shape.refined(2);
    result.pieces = coarse.pieces->split(whole);
    return result;
  }
  const auto& [pieces, problem] = *finer;
  result.pieces = coarse.pieces->split(pieces->whole());
  result.refinement.setup = result.pieces->piece();
  result.refinement.irradiance =
      own_maps(*pieces, problem.setup.lit_face, problem.patterns, problem.irradiance,
               pieces->held(), result.pieces->held());
  return result;
}

CoefficientPair to_finer(const CoefficientPair& own, const BlockPieces& coarse,
                         const BlockPieces& finer) {
  const GridShape& from = coarse.piece().shape;
  const GridShape to = from.refined(2);
  const auto& origin = coarse.held().begin;
  const Box& box = finer.owned();
  const auto finer_field = [&](const std::vector<double>& values) {
    std::vector<double> piece(from.cells());
    coarse.for_own([&](std::size_t i, std::size_t k) { piece[i] = values[k]; });
    coarse.exchange(piece);
    const std::vector<double> all = prolong(piece, from, to);
    std::vector<double> result;
    result.reserve(box.cells());
    for (int z = box.begin[2]; z < box.end[2]; ++z) {
      for (int y = box.begin[1]; y < box.end[1]; ++y) {
        for (int x = box.begin[0]; x < box.end[0]; ++x) {
          result.push_back(all[to.index(x - 2 * origin[0], y - 2 * origin[1], z - 2 * origin[2])]);
        }
      }
    }
    return result;
  };
  return {finer_field(own.log_kappa), finer_field(own.log_mu)};
}

Problem whole_problem(const PieceGrid& grid) {
  constexpr double most_data = 1 << 22;
  const double data =
      static_cast<double>(grid.problem.patterns) *
      static_cast<double>(face_shape(grid.pieces->whole().shape, grid.problem.seen_face).cells());
  int factor = 1;
  while (data / (factor * factor) > most_data) factor *= 2;
  return averaged(*grid.pieces, grid.problem, factor);
}

HomogeneousFit find_start(const PieceGrid& grid, const std::optional<HomogeneousGuess>& guess) {
  const BlockPieces& pieces = *grid.pieces;
  const Problem whole = whole_problem(grid);
  HomogeneousFit start;
  forward::distributed::on_first(pieces.comm(), [&] { start = find_homogeneous(whole, guess); });
  std::array<double, 4> numbers{start.kappa, start.mu, start.log_residual,
                                start.converged ? 1.0 : 0.0};
  MPI_Bcast(numbers.data(), 4, MPI_DOUBLE, 0, pieces.comm());
  start.kappa = numbers[0];
  start.mu = numbers[1];
  start.log_residual = numbers[2];
  start.converged = numbers[3] != 0.0;
  return start;
}

double quantile(const BlockPieces& pieces, const std::vector<double>& values, double share) {
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (const double value : values) {
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  MPI_Allreduce(MPI_IN_PLACE, &lowest, 1, MPI_DOUBLE, MPI_MIN, pieces.comm());
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_DOUBLE, MPI_MAX, pieces.comm());
  const double count = pieces.sum(static_cast<double>(values.size()));
  if (count == 0.0) return 0.0;
  while (highest - lowest > 1e-6 * std::abs(highest)) {
    const double middle = 0.5 * (lowest + highest);
    const auto below =
        std::count_if(values.begin(), values.end(), [&](double value) { return value <= middle; });
    (pieces.sum(static_cast<double>(below)) > share * count ? highest : lowest) = middle;
  }
  return highest;
}

}  // namespace kappamu::inverse::distributed
