#include "bench/forward/slab_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace kappamu::bench {

namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

/// Where every search begins, whatever was published: albedo and thickness in mean free paths.
constexpr double first_albedo = 0.9, first_paths = 3.0;
constexpr int most_renewals = 30;
constexpr int most_steps = 40;
constexpr double settled_move = 2e-3;  // log units
constexpr double longest_step = 0.7;   // log units
constexpr double difference = 1e-3;    // log units, of derivatives

/// p: log σa, log σs'.
MeasuredSlab with(MeasuredSlab slab, const Vector2& p) {
  slab.sigma_a = std::exp(p[0]);
  slab.sigma_s_prime = std::exp(p[1]);
  return slab;
}

Vector2 totals(const SlabPrediction& p) {
  return {p.reflectance, p.transmittance};
}

Vector2 diffusion(const MeasuredSlab& slab, const Vector2& p) {
  return totals(predict_by_diffusion(with(slab, p)));
}

/// Of r times diffusion's totals.
Matrix2 jacobian(const MeasuredSlab& slab, const Vector2& p, const Vector2& r) {
  Matrix2 j;
  for (int k = 0; k < 2; ++k) {
    const Vector2 step = difference * Vector2::Unit(k);
    j.col(k) =
        r.cwiseProduct(diffusion(slab, p + step) - diffusion(slab, p - step)) / (2.0 * difference);
  }
  return j;
}

/// Levenberg-Marquardt on r D(p) = measured.
Vector2 solve(const MeasuredSlab& slab, Vector2 p, const Vector2& r) {
  const Vector2 measured(slab.reflectance, slab.transmittance);
  const auto residual = [&](const Vector2& at) {
    return Vector2(r.cwiseProduct(diffusion(slab, at)) - measured);
  };
  Vector2 here = residual(p);
  double damping = 1e-4;
  for (int k = 0; k < most_steps; ++k) {
    const Matrix2 j = jacobian(slab, p, r);
    Matrix2 normal = j.transpose() * j;
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-12;
    const Vector2 step =
        (-normal.ldlt().solve(j.transpose() * here)).cwiseMax(-longest_step).cwiseMin(longest_step);
    const Vector2 there = residual(p + step);
    if (there.squaredNorm() < here.squaredNorm()) {
      p += step;
      here = there;
      damping *= 0.2;
      if (step.cwiseAbs().maxCoeff() < 0.1 * settled_move) break;
    } else {
      damping = std::max(1e-6, 10.0 * damping);
      if (damping > 1e8) break;
    }
  }
  return p;
}

}  // namespace

SlabFit fit_slab(const MeasuredSlab& slab, bool transport, std::uint64_t photons,
                 std::uint64_t seed) {
  const double extinction = first_paths / slab.thickness;
  Vector2 p(std::log((1.0 - first_albedo) * extinction), std::log(first_albedo * extinction));
  Vector2 r = Vector2::Ones();
  p = solve(slab, p, r);
  SlabFit fit;
  Vector2 error = Vector2::Zero();
  while (transport && !fit.settled && fit.renewals < most_renewals) {
    const SlabPrediction by_photons = predict_by_photons(with(slab, p), photons, seed);
    r = totals(by_photons).cwiseQuotient(diffusion(slab, p));
    const Vector2 next = solve(slab, p, r);
    ++fit.renewals;
    const Matrix2 inverse = jacobian(slab, next, r).inverse();
    const Vector2 noise(by_photons.reflectance_error, by_photons.transmittance_error);
    error = (inverse * noise.asDiagonal()).rowwise().norm();
    const Vector2 move = (next - p).cwiseAbs();
    fit.settled =
        move[0] < std::max(settled_move, error[0]) && move[1] < std::max(settled_move, error[1]);
    p = next;
  }
  fit.sigma_a = std::exp(p[0]);
  fit.sigma_s_prime = std::exp(p[1]);
  fit.sigma_a_error = error[0];
  fit.sigma_s_prime_error = error[1];
  return fit;
}

}  // namespace kappamu::bench
