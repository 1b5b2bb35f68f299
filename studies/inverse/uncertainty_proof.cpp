#include "studies/inverse/uncertainty_proof.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "inverse/optimise/lateral_hessian.h"
#include "inverse/problem/problem.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using inverse::CoefficientPair;

/// Smooth fields with an absorbing box; relative position decides, so every grid shows the same.
CoefficientPair medium(const GridShape& shape) {
  TruthSpec spec;
  spec.contrast = 2.0;
  spec.seed = 3;
  return make_truth(shape, spec);
}

VectorXd normals(Noise& random, Index count) {
  VectorXd values(count);
  for (double& x : values) x = random.normal();
  return values;
}

/// Without noise, with the variances of noisy ones.
SurfaceMeasurements exact_measurements(const ProofOptions& options) {
  Block block;
  block.grid = options.grid;
  block.noise = options.noise;
  SurfaceMeasurements measurements =
      expose_patches(block, medium(options.grid.refined(2)), options.side);
  const std::vector<float> exact = measurements.value;
  add_noise(measurements, options.noise, options.seed);  // for the variances it states
  measurements.value = exact;
  return measurements;
}

inverse::FitOptions fit_options(const ProofOptions& options) {
  inverse::FitOptions fit;
  fit.path.weight = options.weight;
  fit.data.model_error = {0.0, 0.0};
  fit.solver.backend.device = options.device;
  fit.solver.backend.precision = forward::Precision::double_precision;
  fit.solver.backend.solve = {1e-9, 500};
  return fit;
}

}  // namespace

Proof::Proof(const ProofOptions& options)
    : options_(options),
      fit_(exact_measurements(options), 0, fit_options(options)),
      noise_(options.seed) {
  const MatrixXd identity = MatrixXd::Identity(unknowns(), unknowns());
  posterior_ = fit_.covariance().diagonal();
  prior_ = fit_.precision().llt().solve(identity).diagonal();
  noise_part_ =
      posterior_ -
      (fit_.covariance() * fit_.precision()).cwiseProduct(fit_.covariance()).rowwise().sum();
}

Variances Proof::sampled_noise_part(int count) {
  VectorXd sum = VectorXd::Zero(unknowns());
  VectorXd squares = sum;
  const inverse::Problem& problem = fit_.objective().problem();
  for (int k = 0; k < count; ++k) {
    std::vector<double> data = problem.data;
    for (std::size_t i = 0; i < data.size(); ++i) {
      const double weight = problem.weight[i];
      if (weight > 0.0) data[i] += noise_.normal() / std::sqrt(weight);
    }
    const VectorXd change = fit_.refitted(data);
    sum += change;
    squares += change.cwiseAbs2();
  }
  return (squares - sum.cwiseAbs2() / count) / (count - 1);
}

Variances Proof::sampled_posterior(int count) {
  const Eigen::LLT<MatrixXd> root(fit_.precision());  // P = L Lᵀ: L⁻ᵀ ξ has covariance P⁻¹
  VectorXd squares = VectorXd::Zero(unknowns());
  for (int k = 0; k < count; ++k) {
    const VectorXd truth = root.matrixU().solve(normals(noise_, unknowns()));
    const VectorXd data = fit_.jacobian() * truth + normals(noise_, fit_.jacobian().rows());
    squares += (fit_.covariance() * (fit_.jacobian().transpose() * data) - truth).cwiseAbs2();
  }
  return squares / count;
}

Variances Proof::estimated_posterior(int probes) {
  const inverse::Problem& problem = fit_.objective().problem();
  const inverse::MediumSpace& space = fit_.objective().space();
  const std::vector<inverse::CoefficientPair> rows =
      inverse::random_rows(fit_.objective(), probes, options_.seed);
  const inverse::Uncertainty found = inverse::estimate_uncertainty(
      fit_.prior(), space, problem.seen_face, inverse::prior_blocks(rows, space),
      inverse::estimate_sensitivity(rows), {});
  const Index cells = unknowns() / 2;
  Variances variances(unknowns());
  for (Index i = 0; i < cells; ++i) {
    const auto at = static_cast<std::size_t>(i);
    variances[i] = std::pow(found.log_kappa_std[at], 2);
    variances[cells + i] = std::pow(found.log_mu_std[at], 2);
  }
  return variances;
}

DeviationRatio deviation_ratio(const Variances& found, const Variances& expected,
                               const std::vector<bool>& use) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < use.size(); ++i) {
    const auto at = static_cast<Index>(i);
    if (use[i]) ratios.push_back(std::sqrt(found[at] / expected[at]));
  }
  if (ratios.empty()) return {};
  std::sort(ratios.begin(), ratios.end());
  const auto quantile = [&](double share) {
    return ratios[static_cast<std::size_t>(std::lround(share * (ratios.size() - 1.0)))];
  };
  return {quantile(0.05), quantile(0.5), quantile(0.95), ratios.size()};
}

}  // namespace kappamu::studies
