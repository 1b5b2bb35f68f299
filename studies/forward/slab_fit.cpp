#include "studies/forward/slab_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "studies/forward/slabs.h"

namespace kappamu::studies {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int most_refreshes = 12;
constexpr double settled_step = 0.01;     // log units
constexpr double slope_difference = 0.2;  // log units, downwards
constexpr double longest = 0.7;           // log units

/// `slab` with log σa and log σs' of x.
MeasuredSlab with(MeasuredSlab slab, const Vector2d& x) {
  slab.sigma_a = std::exp(x[0]);
  slab.sigma_s_prime = std::exp(x[1]);
  return slab;
}

Vector2d logs(double reflectance, double transmittance) {
  return {std::log(reflectance), std::log(std::max(transmittance, 1e-12))};
}

Vector2d by_diffusion(const MeasuredSlab& slab, const Vector2d& x) {
  const SlabPrediction p = slab_by_diffusion(with(slab, x));
  return logs(p.reflectance, p.transmittance);
}

Matrix2d diffusion_slope(const MeasuredSlab& slab, const Vector2d& x) {
  constexpr double step = 1e-4;
  Matrix2d slope;
  for (int k = 0; k < 2; ++k) {
    const Vector2d d = step * Vector2d::Unit(k);
    slope.col(k) = (by_diffusion(slab, x + d) - by_diffusion(slab, x - d)) / (2.0 * step);
  }
  return slope;
}

/// x where log M by diffusion + `log_r` + `r_slope` (x − x0) is the data's: Levenberg-Marquardt, as
/// there may be none.
Vector2d solve(const MeasuredSlab& slab, Vector2d x, const Vector2d& log_r,
               const Matrix2d& r_slope) {
  const Vector2d x0 = x;
  const Vector2d data = logs(slab.reflectance, slab.transmittance);
  const auto residual = [&](const Vector2d& at) -> Vector2d {
    return by_diffusion(slab, at) + log_r + r_slope * (at - x0) - data;
  };
  Vector2d f = residual(x);
  double damping = 1e-3;
  for (int k = 0; k < 60 && f.norm() > 1e-7; ++k) {
    const Matrix2d jacobian = diffusion_slope(slab, x) + r_slope;
    Matrix2d normal = jacobian.transpose() * jacobian;
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-12;
    const Vector2d next =
        x - normal.ldlt().solve(jacobian.transpose() * f).cwiseMax(-longest).cwiseMin(longest);
    const Vector2d there = residual(next);
    const bool better = there.allFinite() && there.norm() < f.norm();
    damping = better ? 0.2 * damping : 8.0 * damping;
    if (!better) continue;
    x = next;
    f = there;
  }
  return x;
}

}  // namespace

SlabCoefficients fit_by_diffusion(const MeasuredSlab& slab) {
  // From a clear slab of three mean free paths, which tells both totals from nothing.
  const Vector2d start(std::log(0.05 / slab.thickness), std::log(3.0 / slab.thickness));
  const Vector2d x = solve(slab, start, Vector2d::Zero(), Matrix2d::Zero());
  const Vector2d missed = by_diffusion(slab, x) - logs(slab.reflectance, slab.transmittance);
  return {std::exp(x[0]), std::exp(x[1]), 0.0, 0.0, 0, missed.norm() < 1e-5};
}

SlabCoefficients fit_by_transport(const MeasuredSlab& slab, const SlabCoefficients& start,
                                  double error, std::uint64_t photons, std::uint64_t seed) {
  Vector2d x(std::log(start.sigma_a), std::log(start.sigma_s_prime));
  SlabCoefficients found;
  while (found.refreshes++ < most_refreshes) {
    const SlabPrediction here = slab_by_photons(with(slab, x), photons, seed);
    const Vector2d transport = logs(here.reflectance, here.transmittance);
    const Vector2d diffusion = by_diffusion(slab, x);
    Matrix2d slope;  // of log r
    for (int k = 0; k < 2; ++k) {
      const Vector2d below = x - slope_difference * Vector2d::Unit(k);
      const SlabPrediction there = slab_by_photons(with(slab, below), photons, seed);
      slope.col(k) = (transport - logs(there.reflectance, there.transmittance) - diffusion +
                      by_diffusion(slab, below)) /
                     slope_difference;
    }
    const Vector2d next = solve(slab, x, transport - diffusion, slope);
    const Matrix2d inverse = (diffusion_slope(slab, x) + slope).inverse();
    const Vector2d noise(std::hypot(here.reflectance_error, error) / slab.reflectance,
                         std::hypot(here.transmittance_error, error) / slab.transmittance);
    const Vector2d deviation = (inverse * noise.asDiagonal()).rowwise().norm();
    const Vector2d step = (next - x).cwiseMax(-longest).cwiseMin(longest);
    x += step;
    found.log_sigma_a_std = deviation[0];
    found.log_sigma_s_std = deviation[1];
    found.settled = (step.array().abs() < (0.5 * deviation.array()).max(settled_step)).all();
    if (found.settled) break;
  }
  found.sigma_a = std::exp(x[0]);
  found.sigma_s_prime = std::exp(x[1]);
  return found;
}

}  // namespace kappamu::studies
