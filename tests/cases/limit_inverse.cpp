#include "tests/cases/limit_inverse.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/numbers/median.h"
#include "inverse/data_checks/consistency.h"
#include "inverse/validation/notes.h"

namespace kappamu::test_cases {

namespace {

/// 4.3 mean free paths thick at `kappa`, voxels of 0.53.
constexpr GridShape small{12, 12, 8, 0.4};
constexpr double kappa = 0.25, mu = 0.01;
constexpr int fine = 2;
constexpr int score_side = 6;  // patches to a side

Figure3 usual() {
  return structured_block(kappa, mu, 1.0, 1);
}

InverseLimit started(const std::string& name, const Block& block, double factor) {
  InverseLimit limit{name, block, usual()};
  limit.options.path.start_kappa = factor * kappa;
  limit.options.path.start_mu = factor * mu;
  return limit;
}

InverseLimit with_outliers(const std::string& name, const Block& block, inverse::Loss loss) {
  InverseLimit limit{name, block, usual()};
  limit.mistake.outliers = 0.01;
  limit.options.data.term.loss = loss;
  return limit;
}

InverseLimit by_transport(InverseLimit limit) {
  limit.name += ", data by Monte Carlo";
  limit.transport = true;
  return limit;
}

InverseLimit fitted_by_transport(InverseLimit limit, double anisotropy = 0.0) {
  limit = by_transport(std::move(limit));
  limit.name += anisotropy > 0.0 ? " of g = 0.8, --physics auto" : ", --physics auto";
  limit.anisotropy = anisotropy;
  limit.options.data.physics = inverse::Physics::automatic;
  return limit;
}

void mask_half(SurfaceMeasurements& m) {
  const FaceShape face = m.seen_shape();
  if (m.mask.empty()) m.mask.assign(m.value.size(), 1);
  for (std::size_t i = 0; i < m.mask.size(); ++i) {
    if (static_cast<int>(i % static_cast<std::size_t>(face.nu)) >= face.nu / 2) m.mask[i] = 0;
  }
}

void score(const InverseLimit& limit, double stated_eta, InverseLimitOutcome& outcome) {
  const Medium& found = outcome.fit->medium;
  const inverse::CoefficientPair truth = on_grid(limit.block.grid, limit.figure);
  std::vector<double> of_kappa, of_mu;
  for (std::size_t i = 0; i < truth.log_mu.size(); ++i) {
    of_kappa.push_back(std::abs(found.kappa[i] / std::exp(truth.log_kappa[i]) - 1.0));
    of_mu.push_back(std::abs(found.mu[i] / std::exp(truth.log_mu[i]) - 1.0));
  }
  outcome.kappa_error = upper_median(std::move(of_kappa));
  outcome.mu_error = upper_median(std::move(of_mu));
  SurfaceMeasurements validation =
      limit.transport ? expose_photons(limit.block, limit.figure, score_side, 2, limit.anisotropy)
                      : expose_figure(limit.block, limit.figure, score_side, fine, limit.eta);
  // As whoever uses the volume would light it: with the eta that was stated.
  validation.eta = stated_eta;
  outcome.error = appearance_error(
      found, validation, inverse::predict_options(limit.options, outcome.fit->report.physics));
}

}  // namespace

std::vector<InverseLimit> inverse_limits() {
  const Block block{.grid = small};
  Block front = block;
  front.seen = Face::z_minus;
  const InverseLimit absorbing{"3κμ = 0.3", block, even_block(0.3, 0.33)};
  const InverseLimit structured = by_transport(
      {"structure, 2.7 mean free paths thick", block, structured_block(0.4, 0.05, 1.0, 1)});
  InverseLimit structured_transport = structured;
  structured_transport.name += ", --physics transport";
  structured_transport.options.data.physics = inverse::Physics::transport;
  const InverseLimit thin{
      "2 mean free paths thick", {.grid = {12, 12, 4, 0.3}}, even_block(0.2, mu)};
  return {
      {"1 % noise", block, usual()},
      {"3 % noise", {.grid = small, .noise = 0.03}, usual()},
      {"10 % noise", {.grid = small, .noise = 0.1}, usual()},
      {"one pattern", block, usual(), 1},
      {"scale 2", block, usual(), 4, {.scale = 2.0}},
      {"scale 0.5", block, usual(), 4, {.scale = 0.5}},
      {"eta 1.3 stated for 1.5", block, usual(), 4, {.stated_eta = 1.3}, 1.5},
      {"images 1 voxel off", block, usual(), 4, {.shift = 1}},
      {"images 3 voxels off", block, usual(), 4, {.shift = 3}},
      started("start 100 times too high", block, 100.0),
      started("start 100 times too low", block, 0.01),
      {"inclusions of contrast 100", block, inclusions(kappa, mu, 10.0)},
      absorbing,
      by_transport(absorbing),
      fitted_by_transport(absorbing),
      thin,
      by_transport(thin),
      fitted_by_transport(thin),
      fitted_by_transport(thin, 0.8),
      fitted_by_transport({"1 mean free path thick", {.grid = {12, 12, 4, 0.15}}, thin.figure}),
      structured,
      structured_transport,
      {.name = "front-lit, half the face masked",
       .block = front,
       .figure = usual(),
       .half_masked = true},
      {.name = "all dark", .block = block, .figure = usual(), .dark = true},
      with_outliers("1 % of outliers", block, inverse::Loss::gaussian),
      with_outliers("1 % of outliers, --loss student", block, inverse::Loss::student),
      {"voxels of 0.13 mean free paths", {.grid = {24, 24, 32, 0.1}}, usual()},
      {"the same block, voxels of 0.53", {.grid = {6, 6, 8, 0.4}}, usual()},
  };
}

InverseLimit inverse_limit(const std::string& name) {
  for (InverseLimit& limit : inverse_limits()) {
    if (limit.name == name) return std::move(limit);
  }
  throw InternalError("there is no limit '" + name + "' of the fit");
}

InverseLimitOutcome run_inverse_limit(const InverseLimit& limit, const std::string& device) {
  SurfaceMeasurements m =
      limit.transport ? expose_photons(limit.block, limit.figure, limit.side, 1, limit.anisotropy)
                      : expose_figure(limit.block, limit.figure, limit.side, fine, limit.eta);
  const std::vector<float> photons = m.variance;
  spoil(m, limit.block.noise, limit.mistake);
  if (limit.transport) {
    std::transform(photons.begin(), photons.end(), m.variance.begin(), m.variance.begin(),
                   std::plus<>());
  }
  if (limit.dark) std::fill(m.value.begin(), m.value.end(), 0.0F);
  if (limit.half_masked) mask_half(m);
  inverse::FitOptions options = limit.options;
  options.solver.backend.device = device;
  Progress silent;
  InverseLimitOutcome outcome;
  try {
    outcome.fit = inverse::fit_channel(m, 0, options, {}, silent);
  } catch (const InputError& error) {
    outcome.warnings.emplace_back(error.what());
    return outcome;
  }
  outcome.warnings = outcome.fit->report.warnings;
  for (const auto& warning : {inverse::unseen_warning(*outcome.fit, m, 0),
                              inverse::outlier_warning(*outcome.fit, m, 0)}) {
    if (warning) outcome.warnings.push_back(*warning);
  }
  const inverse::Consistency& consistency = outcome.fit->report.consistency;
  if (inverse::shifted_channel({&consistency, 1})) {
    outcome.warnings.push_back(inverse::shift_sentence(consistency, m.grid, m.seen_face));
  }
  outcome.notes = inverse::notes_on(*outcome.fit, m);
  score(limit, m.eta, outcome);
  return outcome;
}

}  // namespace kappamu::test_cases
