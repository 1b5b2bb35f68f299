#include "bench/uncertainty_bench.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/chart.h"
#include "bench/record.h"
#include "io/atomic_file.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

/// Predicted deviations over which the prior does not rule: the data at least halved its own.
constexpr double told_by_data = 0.25;  // of the prior's variance

std::vector<double> deviations(const Variances& variances, const std::vector<bool>& use,
                               Eigen::Index first, Eigen::Index last) {
  std::vector<double> values;
  for (Eigen::Index i = first; i < last; ++i) {
    if (use[static_cast<std::size_t>(i)]) values.push_back(std::sqrt(variances[i]));
  }
  return values;
}

Chart scatter(const std::string& title, const Variances& predicted, const Variances& sampled,
              const std::vector<bool>& use) {
  const Eigen::Index cells = predicted.size() / 2;
  Chart chart;
  chart.title = title;
  chart.x_label = "predicted standard deviation [log units]";
  chart.y_label = "sampled standard deviation [log units]";
  chart.log_x = chart.log_y = true;
  chart.legend = "left top";
  const auto points = [&](const std::string& label, Eigen::Index first, Eigen::Index last) {
    chart.series.push_back({label,
                            deviations(predicted, use, first, last),
                            deviations(sampled, use, first, last),
                            {},
                            Series::Style::points,
                            {}});
  };
  points("log κ", 0, cells);
  points("log μ", cells, 2 * cells);
  const std::vector<double> all = deviations(predicted, use, 0, 2 * cells);
  const auto [low, high] = std::minmax_element(all.begin(), all.end());
  for (const double factor : {0.75, 1.0, 1.25}) {
    chart.series.push_back({factor == 1.0 ? "equal, ± 25 %" : "",
                            {*low, *high},
                            {factor * *low, factor * *high},
                            {},
                            Series::Style::dashes,
                            8});
  }
  return chart;
}

Chart costs(const std::vector<UncertaintyRow>& rows) {
  Chart chart;
  chart.title = "Standard deviations against the exact posterior's: 5 %, median, 95 %";
  chart.x_label = "batched solves";
  chart.y_label = "estimated over exact";
  chart.log_x = chart.log_y = true;
  const auto add = [&](const std::string& label, const std::string& begins, int colour) {
    for (const auto& [member, style] :
         {std::pair{&DeviationRatio::median, Series::Style::line_and_points},
          std::pair{&DeviationRatio::low, Series::Style::dashes},
          std::pair{&DeviationRatio::high, Series::Style::dashes}}) {
      Series series;
      series.label = member == &DeviationRatio::median ? label : "";
      series.style = style;
      series.colour = colour;
      for (const UncertaintyRow& row : rows) {
        if (row.method.rfind(begins, 0) != 0) continue;
        series.x.push_back(row.solves);
        series.y.push_back(row.ratio.*member);
      }
      chart.series.push_back(std::move(series));
    }
  };
  add("sampled", "samples", 1);
  add("low rank, at best", "rank", 2);
  return chart;
}

Json to_json(const std::vector<UncertaintyRow>& rows) {
  Json array = Json::array();
  for (const UncertaintyRow& row : rows) {
    array.push_back({{"method", row.method},
                     {"batched_solves", row.solves},
                     {"unknowns", row.ratio.count},
                     {"ratio_5", row.ratio.low},
                     {"ratio_median", row.ratio.median},
                     {"ratio_95", row.ratio.high}});
  }
  return array;
}

std::string table(const std::vector<UncertaintyRow>& rows) {
  std::string text;
  for (const UncertaintyRow& row : rows) {
    char line[200];
    std::snprintf(line, sizeof line, "| %s | %s | %zu | %.2f | %.2f | %.2f |\n", row.method.c_str(),
                  row.solves > 0 ? std::to_string(row.solves).c_str() : "", row.ratio.count,
                  row.ratio.low, row.ratio.median, row.ratio.high);
    text += line;
  }
  return text;
}

void estimate_all(Proof& proof, UncertaintyBench& bench, Progress& progress) {
  const std::vector<bool> all(static_cast<std::size_t>(proof.unknowns()), true);
  inverse::UncertaintyOptions options;
  for (const int samples : {1, 2, 4, 8, 16, 32}) {
    progress.update("uncertainty", 0.6 + 0.01 * samples, "samples");
    options.samples = samples;
    int solves = 0;
    const Variances found = proof.estimated_posterior(options, solves);
    bench.estimators.push_back({"samples, " + std::to_string(samples), solves,
                                deviation_ratio(found, proof.posterior(), all)});
  }
  for (int rank = 16; rank <= proof.unknowns() / 2; rank *= 2) {
    // A randomised method needs more than one product with J and one with Jᵀ per direction.
    bench.estimators.push_back(
        {"rank " + std::to_string(rank), 2 * rank,
         deviation_ratio(proof.low_rank_posterior(rank), proof.posterior(), all)});
  }
}

}  // namespace

UncertaintyBench measure_uncertainty(const UncertaintyBenchOptions& options, Progress& progress) {
  progress.update("uncertainty", 0.0, "the fitted block, dense");
  Proof proof(options.proof);
  const std::vector<bool> all(static_cast<std::size_t>(proof.unknowns()), true);
  std::vector<bool> told;
  for (Eigen::Index i = 0; i < proof.unknowns(); ++i) {
    told.push_back(proof.posterior()[i] < told_by_data * proof.prior()[i]);
  }
  UncertaintyBench bench;
  progress.update("uncertainty", 0.2, "fits to fresh noise");
  const Variances fits = proof.sampled_noise_part(options.fits);
  bench.proof.push_back({"fits to fresh noise, where the data halved the deviation", 0,
                         deviation_ratio(fits, proof.noise_part(), told)});
  bench.proof.push_back(
      {"fits to fresh noise, all", 0, deviation_ratio(fits, proof.noise_part(), all)});
  progress.update("uncertainty", 0.5, "truths from the prior");
  const Variances errors = proof.sampled_posterior(options.truths);
  bench.proof.push_back(
      {"truths from the prior", 0, deviation_ratio(errors, proof.posterior(), all)});
  inverse::UncertaintyOptions usual;
  usual.samples = 4;
  int solves = 0;
  const Variances stated = proof.estimated_posterior(usual, solves);
  bench.proof.push_back({"truths from the prior, against `kappamu fit`'s own figure", solves,
                         deviation_ratio(errors, stated, all)});
  estimate_all(proof, bench, progress);

  const std::filesystem::path& folder = options.folder;
  Json record = record_header("uncertainty", proof.objective().backend_name());
  const GridShape& s = options.proof.grid;
  record["grid"] = {s.nx, s.ny, s.nz};
  record["voxel_mm"] = s.voxel_mm;
  record["patterns"] = options.proof.side * options.proof.side;
  record["noise"] = options.proof.noise;
  record["weight"] = options.proof.weight;
  record["fits"] = options.fits;
  record["truths"] = options.truths;
  record["gradient_left"] = proof.unconverged();
  record["proof"] = to_json(bench.proof);
  record["estimators"] = to_json(bench.estimators);
  write_record(record, folder / "uncertainty.json");
  const std::vector<Chart> scatters{
      scatter("Fits to fresh noise", proof.noise_part(), fits, told),
      scatter("Truths from the prior, against kappamu fit's own figure", stated, errors, all)};
  draw(scatters, folder / "bench-uncertainty.png", 2, 760, 640);
  draw(std::vector<Chart>{costs(bench.estimators)}, folder / "bench-uncertainty-cost.png");
  io::write_text_atomically(
      folder / "table-uncertainty.md",
      "| sampled over predicted | solves | unknowns | 5 % | median | 95 % "
      "|\n|---|---|---|---|---|---|\n" +
          table(bench.proof) +
          "\n| estimated over exact | solves | unknowns | 5 % | median | 95 % |\n"
          "|---|---|---|---|---|---|\n" +
          table(bench.estimators));
  return bench;
}

}  // namespace kappamu::bench
