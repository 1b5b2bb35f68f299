// The standard deviations of a fit proved by sampling, and what each estimate of them costs.
#include <cmath>
#include <nlohmann/json.hpp>

#include "studies/inverse/uncertainty_proof.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

/// Share of the prior's variance below which the data at least halved the prior's deviation.
constexpr double halved = 0.25;

Json row_of(const std::string& part, const std::string& method, int solves,
            const DeviationRatio& ratio) {
  return {{"part", part},
          {"method", method},
          {"batched_solves", solves},
          {"unknowns", ratio.count},
          {"ratio_5", ratio.low},
          {"ratio_median", ratio.median},
          {"ratio_95", ratio.high}};
}

/// Deviations of the unknowns in use, those of κ before those of μ.
Json scatter(const std::string& title, const Variances& predicted, const Variances& sampled,
             const std::vector<bool>& use) {
  Json chart{{"title", title}};
  const Eigen::Index cells = predicted.size() / 2;
  for (Eigen::Index i = 0; i < predicted.size(); ++i) {
    if (!use[static_cast<std::size_t>(i)]) continue;
    const char* name = i < cells ? "log_kappa" : "log_mu";
    chart[name]["predicted"].push_back(std::sqrt(predicted[i]));
    chart[name]["sampled"].push_back(std::sqrt(sampled[i]));
  }
  return chart;
}

void estimate_all(Proof& proof, Progress& progress, Json& rows) {
  const std::vector<bool> all(static_cast<std::size_t>(proof.unknowns()), true);
  for (const int probes : {2, 4, 8, 16, 32}) {
    progress.update("uncertainty", 0.6 + 0.01 * probes, "probes");
    rows.push_back(
        row_of("estimated over exact", "probes, " + std::to_string(probes), probes,
               deviation_ratio(proof.estimated_posterior(probes), proof.posterior(), all)));
  }
}

void measure(const Request& request, Progress& progress, const Save& save) {
  ProofOptions options;
  const bool quick = request.size == Size::quick;
  if (request.size != Size::full) {
    options.grid = {8, 8, 4, 0.5};
    options.side = 3;
  }
  options.device = request.device;
  options.seed = request.seed;
  const int fits = quick ? 10 : 60, truths = quick ? 100 : 1000;
  progress.update("uncertainty", 0.0, "the fitted block, dense");
  Proof proof(options);
  const std::vector<bool> all(static_cast<std::size_t>(proof.unknowns()), true);
  std::vector<bool> by_data;
  for (Eigen::Index i = 0; i < proof.unknowns(); ++i) {
    by_data.push_back(proof.posterior()[i] < halved * proof.prior()[i]);
  }
  const char* sampled = "sampled over predicted";
  Json rows = Json::array();
  progress.update("uncertainty", 0.2, "fits to fresh noise");
  const Variances fitted = proof.sampled_noise_part(fits);
  rows.push_back(row_of(sampled, "fits to fresh noise, where the data halved the deviation", 0,
                        deviation_ratio(fitted, proof.noise_part(), by_data)));
  rows.push_back(row_of(sampled, "fits to fresh noise, all", 0,
                        deviation_ratio(fitted, proof.noise_part(), all)));
  progress.update("uncertainty", 0.5, "truths from the prior");
  const Variances errors = proof.sampled_posterior(truths);
  rows.push_back(
      row_of(sampled, "truths from the prior", 0, deviation_ratio(errors, proof.posterior(), all)));
  const Variances stated = proof.estimated_posterior(inverse::usual_probes);
  rows.push_back(row_of(sampled, "truths from the prior, against `kappamu fit`'s own figure",
                        inverse::usual_probes, deviation_ratio(errors, stated, all)));
  estimate_all(proof, progress, rows);
  const GridShape& s = options.grid;
  save({{"device", proof.objective().backend_name()},
        {"grid", {s.nx, s.ny, s.nz}},
        {"voxel_mm", s.voxel_mm},
        {"patterns", options.side * options.side},
        {"noise", options.noise},
        {"weight", options.weight},
        {"fits", fits},
        {"truths", truths},
        {"gradient_left", proof.unconverged()},
        {"rows", rows},
        {"scatter",
         {scatter("Fits to fresh noise", proof.noise_part(), fitted, by_data),
          scatter("Truths from the prior, against kappamu fit's own figure", stated, errors,
                  all)}}});
}

}  // namespace

Subject uncertainty_subject() {
  return {"uncertainty",
          "The standard deviations of a fit proved by sampling, and the cost of each estimate",
          R"(  kappamu-studies uncertainty -o out/bench            12 x 12 x 6 voxels, some minutes
  kappamu-studies uncertainty -o out/bench --small    8 x 8 x 4 voxels, under a minute

A block is fitted to data from a grid twice as fine; its posterior is made of dense
matrices. Then (a) data get fresh noise and the full objective is minimised again, with the
same weight and grid correction: the spread of those fits over the predicted one; (b) truths
are drawn from the prior, measured with noise in the linearised problem and estimated: the
spread of the errors over the posterior's; (c) the estimate that `kappamu fit` makes over
the exact posterior, by the number of its adjoint solves.

Ratios of standard deviations, as 5 % quantile, median and 95 % quantile over voxels. Sixty
fits know a deviation to 9 %.)",
          {{"uncertainty", "all", measure}}};
}

}  // namespace kappamu::studies
