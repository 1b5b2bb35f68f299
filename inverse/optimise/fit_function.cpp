#include "inverse/optimise/fit_function.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/numbers/dot.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// Whether a == b, on all cores.
bool equal(const Vector& a, const Vector& b) {
  std::atomic<bool> all{a.size() == b.size()};
  for_pieces(all ? a.size() : 0, [&](std::size_t, std::size_t begin, std::size_t end) {
    if (all && !std::equal(&a[begin], a.data() + end, &b[begin])) all = false;
  });
  return all;
}

void add_scaled(Vector& to, double factor, const Vector& term) {
  for_pieces(to.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) to[i] += factor * term[i];
  });
}

void add_scaled(CoefficientPair& to, double factor, const CoefficientPair& term) {
  add_scaled(to.log_kappa, factor, term.log_kappa);
  add_scaled(to.log_mu, factor, term.log_mu);
}

}  // namespace

FitFunction::FitFunction(Objective& objective, const Basis& basis, const Anchor& anchor,
                         double weight, const Regulariser& regulariser, CoefficientPair start,
                         const AbsorptionScale& scale)
    : objective_(objective),
      basis_(basis),
      anchor_(anchor),
      weight_(weight),
      regulariser_(regulariser),
      scale_(scale),
      start_{coordinates(start), std::move(start)} {}

Vector FitFunction::coordinates(const CoefficientPair& fields) const {
  return basis_.from_fields(scale_.from_fields(fields));
}

CoefficientPair FitFunction::fields(const Vector& z) const {
  if (equal(z, start_.z)) return start_.fields;
  return equal(z, here_.z) ? here_.fields : scale_.to_fields(basis_.to_fields(z));
}

CoefficientPair FitFunction::start_fields(const Vector& z) const {
  return equal(z, start_.z) ? start_.fields : CoefficientPair{};
}

void FitFunction::come_to(const Vector& z, CoefficientPair fields) {
  here_ = {z, std::move(fields)};
  roughness_ =
      roughness(objective_.space(), here_.fields, anchor_, regulariser_, std::move(roughness_));
}

void FitFunction::go_to(const Vector& z) {
  if (equal(z, here_.z)) return;
  if (equal(z, ahead_.z)) {
    std::swap(here_, ahead_);
  } else {
    here_ = {z, fields(z)};
  }
}

double FitFunction::value(const Vector& z) {
  go_to(z);
  roughness_ =
      roughness(objective_.space(), here_.fields, anchor_, regulariser_, std::move(roughness_));
  return objective_.value(here_.fields) + weight_ * roughness_.value;
}

Vector FitFunction::gradient() {
  CoefficientPair sum = objective_.gradient();
  add_scaled(sum, weight_, roughness_.gradient);
  return basis_.gradient(scale_.by_scaled(here_.fields, std::move(sum)));
}

void FitFunction::adopt(const FitFunction& before, Vector& step, Vector& change) const {
  change = basis_.carried_gradient(before.basis_, change);
  const double added = weight_ - before.weight_;
  if (added != 0.0) {
    const CoefficientPair moved = before.basis_.to_fields(step);
    const CoefficientPair smoothing =
        smoothing_product(objective_.space(), anchor_.length_mm, roughness_.diffusivity,
                          scale_.by_scaled(here_.fields, moved));
    add_scaled(change, added, basis_.gradient(scale_.by_scaled(here_.fields, smoothing)));
  }
  step = basis_.carried(before.basis_, step);
}

/// With H = JᵀWJ + βR'' and g = R' at the minimum under α, where the data's gradient is −α g: the
/// step is d = (α − β) H⁻¹ g, and −Δχ² = 2α g·d − d·JᵀWJ d = (α² − β²) g·H⁻¹ g + β d·R'' d.
double FitFunction::chi2_gain(const CoefficientPair& fields, const Basis& basis,
                              double weight) const {
  const Roughness here = roughness(objective_.space(), fields, anchor_, regulariser_);
  Vector root = basis.gradient(here.gradient);
  const double square = dot(root, root);
  for (double& x : root) x *= weight_ - weight;
  const CoefficientPair step = basis.to_fields(root);
  const CoefficientPair smoothing =
      smoothing_product(objective_.space(), anchor_.length_mm, here.diffusivity, step);
  const double bend = dot(step.log_kappa, smoothing.log_kappa) + dot(step.log_mu, smoothing.log_mu);
  return (weight_ * weight_ - weight * weight) * square + weight * bend;
}

double FitFunction::amplitude(const Vector& z, const Vector& direction) {
  go_to(z);
  ahead_.z = z;
  for_pieces(z.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ahead_.z[i] += direction[i];
  });
  ahead_.fields = fields(ahead_.z);
  std::vector<double> largest(pieces(here_.fields.log_mu.size()), 0.0);
  for_pieces(
      here_.fields.log_mu.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
        double of_piece = 0.0;
        for (std::size_t i = begin; i < end; ++i) {
          of_piece =
              std::max({of_piece, std::abs(ahead_.fields.log_kappa[i] - here_.fields.log_kappa[i]),
                        std::abs(ahead_.fields.log_mu[i] - here_.fields.log_mu[i])});
        }
        largest[piece] = of_piece;
      });
  return *std::max_element(largest.begin(), largest.end());
}

}  // namespace kappamu::inverse
