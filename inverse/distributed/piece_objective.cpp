#include "inverse/distributed/piece_objective.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "forward/distributed/distributed_solver.h"
#include "forward/distributed/together.h"

namespace kappamu::inverse::distributed {

namespace {

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

/// The whole problem on the first rank, averaged over factor × factor pixels; the other ranks'
/// arrays mean nothing.
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

}  // namespace

Problem piece_problem(const BlockPieces& pieces, const SurfaceMeasurements& measured,
                      forward::Convention convention, const ModelError& error) {
  SurfaceMeasurements independent = measured;
  independent.smooth_error = {};
  Problem problem = make_problem(independent, 0, convention, {error.relative, 0.0});
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
  return problem;
}

HomogeneousFit find_start(const BlockPieces& pieces, const Problem& problem) {
  constexpr double most_data = 1 << 22;
  const double data =
      static_cast<double>(problem.patterns) *
      static_cast<double>(face_shape(pieces.whole().shape, problem.seen_face).cells());
  int factor = 1;
  while (data / (factor * factor) > most_data) factor *= 2;
  const Problem whole = averaged(pieces, problem, factor);
  HomogeneousFit start;
  forward::distributed::on_first(pieces.comm(), [&] { start = find_homogeneous(whole); });
  std::array<double, 4> numbers{start.kappa, start.mu, start.log_residual,
                                start.converged ? 1.0 : 0.0};
  MPI_Bcast(numbers.data(), 4, MPI_DOUBLE, 0, pieces.comm());
  start.kappa = numbers[0];
  start.mu = numbers[1];
  start.log_residual = numbers[2];
  start.converged = numbers[3] != 0.0;
  return start;
}

PieceObjective::PieceObjective(std::shared_ptr<const BlockPieces> pieces, Problem problem,
                               Backend backend, const Anchor& anchor)
    : pieces_(std::move(pieces)),
      objective_(std::move(problem),
                 [&] {
                   backend.operators = forward::distributed::distributed_operators(pieces_);
                   return std::move(backend);
                 }()),
      anchor_(anchor),
      used_(pieces_->sum(static_cast<double>(objective_.problem().used()))) {
  const std::size_t cells = pieces_->piece().shape.cells();
  fields_ = {std::vector<double>(cells, anchor.log_kappa),
             std::vector<double>(cells, anchor.log_mu)};
}

double PieceObjective::value(std::span<const double> own) {
  const std::size_t count = pieces_->owned().cells();
  double largest = 0.0;
  for (const double x : own) {
    if (!(std::abs(x) <= largest)) largest = std::abs(x);
    if (std::isnan(largest)) largest = std::numeric_limits<double>::infinity();
  }
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, pieces_->comm());
  if (!(largest <= max_log_coefficient)) return std::numeric_limits<double>::infinity();
  pieces_->for_own([&](std::size_t i, std::size_t k) {
    fields_.log_kappa[i] = own[k];
    fields_.log_mu[i] = own[count + k];
  });
  pieces_->exchange(fields_.log_kappa);
  pieces_->exchange(fields_.log_mu);
  objective_.forget();
  misfit_ = pieces_->sum(objective_.value(fields_));

  // A voxel's own gradient gathers from all its neighbours, so that of the piece is exact but in
  // the halo; and a quadratic form about the anchor is half its argument times its gradient.
  roughness_ = inverse::roughness(objective_.space(), fields_, anchor_);
  double product = 0.0;
  pieces_->for_own([&](std::size_t i, std::size_t) {
    product += (fields_.log_kappa[i] - anchor_.log_kappa) * roughness_.gradient.log_kappa[i] +
               (fields_.log_mu[i] - anchor_.log_mu) * roughness_.gradient.log_mu[i];
  });
  roughness_.value = 0.5 * pieces_->sum(product);
  return misfit_ + weight_ * roughness_.value;
}

void PieceObjective::gradient(std::span<double> own) {
  const CoefficientPair of_data = objective_.gradient();
  const std::size_t count = pieces_->owned().cells();
  pieces_->for_own([&](std::size_t i, std::size_t k) {
    own[k] = of_data.log_kappa[i] + weight_ * roughness_.gradient.log_kappa[i];
    own[count + k] = of_data.log_mu[i] + weight_ * roughness_.gradient.log_mu[i];
  });
}

}  // namespace kappamu::inverse::distributed
