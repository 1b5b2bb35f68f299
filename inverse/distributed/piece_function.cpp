#include "inverse/distributed/piece_function.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/dot.h"

namespace kappamu::inverse::distributed {

double product(const BlockPieces& pieces, const Vector& a, const Vector& b) {
  return pieces.sum(dot(a, b));
}

double mean_slope(const BlockPieces& pieces, const AbsorptionScale& scale,
                  const CoefficientPair& own) {
  const auto count = static_cast<double>(own.log_mu.size());
  const double square = std::pow(scale.mean_slope(own), 2) * count;
  return std::sqrt(pieces.sum(square) / static_cast<double>(pieces.whole().shape.cells()));
}

PieceFunction::PieceFunction(PieceObjective& objective, const Basis& basis,
                             const AbsorptionScale& scale, CoefficientPair start)
    : objective_(objective),
      basis_(basis),
      scale_(scale),
      start_(std::move(start)),
      start_z_(coordinates(start_)) {}

/// On all ranks.
bool PieceFunction::alike(const Vector& a, const Vector& b) const {
  return objective_.pieces().sum(a == b ? 0.0 : 1.0) == 0.0;
}

void PieceFunction::total(std::span<double> products) const {
  objective_.pieces().sum(products);
}

Vector PieceFunction::coordinates(const CoefficientPair& own) const {
  return basis_.from_fields(scale_.from_fields(own));
}

CoefficientPair PieceFunction::fields(const Vector& z) const {
  if (alike(z, start_z_)) return start_;
  return alike(z, here_z_) ? here_ : scale_.to_fields(basis_.to_fields(z));
}

double PieceFunction::value(const Vector& z) {
  here_ = fields(z);
  here_z_ = z;
  return objective_.value(here_);
}

Vector PieceFunction::gradient() {
  return basis_.gradient(scale_.by_scaled(here_, objective_.gradient()));
}

double PieceFunction::amplitude(const Vector& z, const Vector& direction) {
  Vector ahead = z;
  for (std::size_t i = 0; i < z.size(); ++i) ahead[i] += direction[i];
  const CoefficientPair from = fields(z), to = fields(ahead);
  double largest = 0.0;
  for (std::size_t i = 0; i < from.log_mu.size(); ++i) {
    largest = std::max({largest, std::abs(to.log_kappa[i] - from.log_kappa[i]),
                        std::abs(to.log_mu[i] - from.log_mu[i])});
  }
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, objective_.pieces().comm());
  return largest;
}

namespace {

std::vector<float> joined(const CoefficientPair& fields) {
  std::vector<float> all(fields.log_kappa.begin(), fields.log_kappa.end());
  all.insert(all.end(), fields.log_mu.begin(), fields.log_mu.end());
  return all;
}

CoefficientPair halves(const Vector& all) {
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  return {{all.begin(), middle}, {middle, all.end()}};
}

}  // namespace

FieldPair PieceFunction::to_fields(const std::vector<float>& step,
                                   const std::vector<float>& change) const {
  return {joined(basis_.to_fields({step.begin(), step.end()})),
          joined(basis_.gradient_by_field({change.begin(), change.end()}))};
}

void PieceFunction::adopt(double before, Vector& step, Vector& change) const {
  const CoefficientPair moved = halves(step);
  CoefficientPair by_field = halves(change);
  const double added = objective_.weight() - before;
  if (added != 0.0) {
    const CoefficientPair smoothing =
        scale_.by_scaled(here_, objective_.smoothing(scale_.by_scaled(here_, moved)));
    for (std::size_t i = 0; i < smoothing.log_mu.size(); ++i) {
      by_field.log_kappa[i] += added * smoothing.log_kappa[i];
      by_field.log_mu[i] += added * smoothing.log_mu[i];
    }
  }
  step = basis_.from_fields(moved);
  change = basis_.gradient(by_field);
}

double PieceFunction::chi2_gain(const Basis& basis, double weight) const {
  const BlockPieces& pieces = objective_.pieces();
  const double here = objective_.weight();
  Vector root = basis.gradient(objective_.roughness_gradient());
  const double square = product(pieces, root, root);
  for (double& x : root) x *= here - weight;
  const CoefficientPair step = basis.to_fields(root);
  const CoefficientPair smoothing = objective_.smoothing(step);
  const double bend = product(pieces, step.log_kappa, smoothing.log_kappa) +
                      product(pieces, step.log_mu, smoothing.log_mu);
  return (here * here - weight * weight) * square + weight * bend;
}

}  // namespace kappamu::inverse::distributed
