#include "inverse/distributed/piece_objective.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "core/error.h"
#include "forward/distributed/distributed_solver.h"
#include "inverse/problem/grid_path.h"

namespace kappamu::inverse::distributed {

namespace {

Backend with_pieces(Backend backend, const PieceGrid& grid,
                    const std::shared_ptr<const BlockPieces>& split) {
  std::vector<std::shared_ptr<const BlockPieces>> pieces{grid.pieces};
  if (split) pieces.push_back(split);
  backend.operators = forward::distributed::distributed_operators(std::move(pieces));
  return backend;
}

Problem mean_held(Problem problem) {
  if (problem.precision) problem.precision->hold_mean(true);
  return problem;
}

}  // namespace

Backend as_loose_as_data(Backend backend, const PieceGrid& grid) {
  const std::vector<double> deviations = relative_deviations(grid.problem);
  const double usual = quantile(*grid.pieces, deviations, 0.5);
  return as_loose_as_data(std::move(backend), usual, quantile(*grid.pieces, deviations, 0.05));
}

PieceObjective::PieceObjective(const PieceGrid& grid, PieceRefinement refinement, Backend backend,
                               const DataTermOptions& data_term, const Anchor& anchor,
                               const Regulariser& regulariser)
    : pieces_(grid.pieces),
      split_(std::move(refinement.pieces)),
      refinement_(std::move(refinement.refinement)),
      objective_(mean_held(grid.problem), with_pieces(std::move(backend), grid, split_), data_term),
      data_term_(data_term),
      anchor_(anchor),
      regulariser_(regulariser),
      used_(pieces_->sum(static_cast<double>(objective_.problem().used()))) {
  check(regulariser.kind != RegulariserKind::wang2008,
        "the regulariser of the paper is not one of pieces");
}

CoefficientPair PieceObjective::own_of(const CoefficientPair& piece) const {
  const std::size_t count = pieces_->owned().cells();
  CoefficientPair own{std::vector<double>(count), std::vector<double>(count)};
  pieces_->for_own([&](std::size_t i, std::size_t k) {
    own.log_kappa[k] = piece.log_kappa[i];
    own.log_mu[k] = piece.log_mu[i];
  });
  return own;
}

CoefficientPair PieceObjective::piece_of(const CoefficientPair& own) const {
  const std::size_t cells = pieces_->piece().shape.cells();
  CoefficientPair piece{std::vector<double>(cells), std::vector<double>(cells)};
  pieces_->for_own([&](std::size_t i, std::size_t k) {
    piece.log_kappa[i] = own.log_kappa[k];
    piece.log_mu[i] = own.log_mu[k];
  });
  pieces_->exchange(piece.log_kappa);
  pieces_->exchange(piece.log_mu);
  return piece;
}

double PieceObjective::value(const CoefficientPair& own) {
  double largest = 0.0;
  for (const std::vector<double>* logs : {&own.log_kappa, &own.log_mu}) {
    for (const double x : *logs) {
      if (!(std::abs(x) <= largest)) largest = std::abs(x);
      if (std::isnan(largest)) largest = std::numeric_limits<double>::infinity();
    }
  }
  CoefficientPair piece;
  double unlike = 1.0;
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, pieces_->comm());
  if (!(largest <= max_log_coefficient)) return std::numeric_limits<double>::infinity();
  piece = piece_of(own);
  unlike = solved_ && piece == fields_ ? 0.0 : 1.0;
  // All ranks solve, or none.
  if (pieces_->sum(unlike) > 0.0) objective_.forget();
  fields_ = std::move(piece);
  set_misfit(objective_.value(fields_));
  solved_ = std::isfinite(misfit_);
  if (!solved_) return misfit_;
  set_roughness();
  return misfit_ + weight_ * roughness_;
}

void PieceObjective::set_misfit(double of_piece) {
  misfit_ = pieces_->sum(of_piece);
  chi2_ = 2.0 * misfit_ / used_;
  if (data_term_.loss == Loss::gaussian || !std::isfinite(misfit_)) return;
  const Problem& problem = objective_.problem();
  const std::vector<double> predicted = objective_.prediction();
  std::vector<double> magnitudes;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    magnitudes.push_back(std::sqrt(problem.weight[i]) * std::abs(predicted[i] - problem.data[i]));
  }
  chi2_ = robust_chi2(quantile(*pieces_, magnitudes, 0.5));
}

/// Of the piece's own voxels. A quadratic form about the anchor is half its argument times its
/// gradient, in which a voxel gathers from its neighbours alone. Huber-TV is such a form, by the
/// diffusivity d of the voxels, and δ²/2 (1/d − 1) of each (Geman and Reynolds 1992).
void PieceObjective::set_roughness() {
  const MediumSpace& space = objective_.space();
  double steps = 0.0;
  if (regulariser_.kind == RegulariserKind::huber_tv) {
    diffusivity_ = inverse::roughness(space, fields_, anchor_, regulariser_).diffusivity;
    pieces_->exchange(diffusivity_);
    const double scale = space.shape.voxel_mm / space.thickness_mm;
    const double step = regulariser_.edge_slope * scale;
    pieces_->for_own([&](std::size_t i, std::size_t) { steps += 1.0 / diffusivity_[i] - 1.0; });
    steps *= 0.5 * scale * step * step;
  }
  CoefficientPair from_anchor = fields_;
  for (double& x : from_anchor.log_kappa) x -= anchor_.log_kappa;
  for (double& x : from_anchor.log_mu) x -= anchor_.log_mu;
  roughness_gradient_ = smoothing_product(space, anchor_.length_mm, diffusivity_, from_anchor);
  double product = 0.0;
  pieces_->for_own([&](std::size_t i, std::size_t) {
    product += from_anchor.log_kappa[i] * roughness_gradient_.log_kappa[i] +
               from_anchor.log_mu[i] * roughness_gradient_.log_mu[i];
  });
  roughness_ = pieces_->sum(0.5 * product + steps);
}

CoefficientPair PieceObjective::gradient() {
  CoefficientPair sum = objective_.gradient();
  for (std::size_t i = 0; i < sum.log_mu.size(); ++i) {
    sum.log_kappa[i] += weight_ * roughness_gradient_.log_kappa[i];
    sum.log_mu[i] += weight_ * roughness_gradient_.log_mu[i];
  }
  return own_of(sum);
}

CoefficientPair PieceObjective::smoothing(const CoefficientPair& own) const {
  return own_of(
      smoothing_product(objective_.space(), anchor_.length_mm, diffusivity_, piece_of(own)));
}

std::vector<CoefficientPair> PieceObjective::random_rows(int probes, std::uint64_t seed) {
  const Problem& problem = objective_.problem();
  const FaceShape whole = face_shape(pieces_->whole().shape, problem.seen_face);
  const FaceShape piece = problem.seen_shape();
  const auto [u_axis, v_axis] = face_axes(problem.seen_face);
  const int first_u = pieces_->held().begin[u_axis], first_v = pieces_->held().begin[v_axis];
  std::vector<CoefficientPair> rows;
  std::mt19937_64 engine(seed);
  std::vector<double> probe(problem.data.size());
  for (int k = 0; k < probes; ++k) {
    for (int m = 0; m < problem.patterns; ++m) {
      for (int v = 0; v < whole.nv; ++v) {
        for (int u = 0; u < whole.nu; ++u) {
          const double sign = (engine() >> 63) != 0 ? 1.0 : -1.0;
          const int at_u = u - first_u, at_v = v - first_v;
          if (at_u < 0 || at_u >= piece.nu || at_v < 0 || at_v >= piece.nv) continue;
          probe[(static_cast<std::size_t>(m) * piece.nv + at_v) * piece.nu + at_u] = sign;
        }
      }
    }
    objective_.weigh_root(probe);
    rows.push_back(own_of(objective_.jacobian_transpose(probe)));
  }
  return rows;
}

double PieceObjective::renew_correction(const CoefficientPair& own) {
  value(own);
  if (!split_) return chi2_per_value();
  // Solved at these very fields, so that no rank solves again.
  set_misfit(objective_.refresh_correction(refinement_, fields_));
  return chi2_per_value();
}

SharedErrors PieceObjective::shared_errors() const {
  const Problem& problem = objective_.problem();
  const std::vector<double> predicted = objective_.prediction();
  SharedErrors found = inverse::shared_errors(problem, data_term_, predicted);
  double light = 0.0, measured = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    light += predicted[i];
    measured += problem.data[i];
  }
  if (inverse::shares_errors(problem, data_term_))
    found.mean = pieces_->sum(light) / pieces_->sum(measured) - 1.0;
  return found;
}

void PieceObjective::count(const SolveCount& before) {
  SolveCount sum = objective_.solves();
  sum.add(before);
  objective_.restore(objective_.correction(), sum);
}

}  // namespace kappamu::inverse::distributed
