#include "app/mpi/piece_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/records/channel_json.h"
#include "pipeline/records/fit_options.h"
#include "pipeline/records/fit_record.h"

namespace kappamu::app::mpi {

using Json = nlohmann::ordered_json;

std::vector<AppearanceError> errors_of(const inverse::distributed::PieceGrid& data,
                                       const std::vector<double>& prediction) {
  const inverse::Problem& problem = data.problem;
  const std::size_t pixels = problem.seen_shape().cells();
  std::vector<double> sums(4 * static_cast<std::size_t>(problem.patterns), 0.0);
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    AppearanceError one;
    one.add(prediction[i], problem.data[i], 1.0 / problem.weight[i]);
    double* const sum = &sums[4 * (i / pixels)];
    sum[0] += one.misfit;
    sum[1] += one.signal;
    sum[2] += one.noise;
    sum[3] += 1.0;
  }
  data.pieces->sum(sums);
  std::vector<AppearanceError> errors;
  for (std::size_t k = 0; k < sums.size(); k += 4) {
    errors.push_back({sums[k], sums[k + 1], sums[k + 2], static_cast<std::size_t>(sums[k + 3])});
  }
  return errors;
}

Json to_json(const PieceRecord& of) {
  pipeline::FitEvidence evidence;
  std::vector<inverse::FitStatus> statuses;
  Json channels = Json::array();
  std::vector<std::string> warnings = of.warnings;
  for (std::size_t c = 0; c < of.names.size(); ++c) {
    const inverse::FitReport& report = of.reports[c];
    evidence.channels.push_back(
        {of.names[c], report.status, report.chi2_per_value, 0.0, report.shared});
    statuses.push_back(report.status);
    Json channel = pipeline::channel_json(of.names[c], report);
    if (!of.validation.empty()) {
      AppearanceError sum;
      for (const AppearanceError& error : of.validation[c].error) sum.add(error);
      channel["validation_E"] = sum.E();
      channel["validation_noise_E"] = sum.noise_E();
      channel["validation_chi2_per_value"] = of.validation[c].score.chi2_per_value;
      channel["validation_values_used"] = sum.count;
      evidence.validation.resize(of.validation[c].error.size());
      for (std::size_t k = 0; k < evidence.validation.size(); ++k) {
        evidence.validation[k].add(of.validation[c].error[k]);
      }
    }
    channels.push_back(std::move(channel));
    for (const std::string& w : report.warnings) warnings.push_back(of.names[c] + ": " + w);
  }
  AppearanceError all;
  for (std::size_t k = 0; k < evidence.validation.size(); ++k) {
    all.add(evidence.validation[k]);
    evidence.validation_names.push_back(of.choice.patterns.empty()
                                            ? "validation pattern " + std::to_string(k)
                                            : "pattern " + std::to_string(of.choice.patterns[k]));
  }
  evidence.used = of.used;
  evidence.front_lit = of.header.lit_face == of.header.seen_face;
  evidence.warnings = warnings.size();
  pipeline::FitRecord record;
  record.status = pipeline::overall_status(statuses);
  record.grid = {of.header.grid.nx, of.header.grid.ny, of.header.grid.nz};
  if (!evidence.validation.empty()) {
    record.validation_E = all.E();
    record.validation_noise_E = all.noise_E();
  }
  record.verdict = pipeline::make_verdict(evidence);
  Json fit{{"format", "kappamu-fit"}, {"version", 1}};
  pipeline::add_fit_record(record, fit);
  fit["voxel_mm"] = of.header.grid.voxel_mm;
  fit["eta"] = of.header.eta;
  fit["device"] = of.reports.front().backend;
  fit["seconds"] = of.seconds;
  fit["memory_peak_bytes"] = *std::max_element(of.memory.begin(), of.memory.end());
  fit["memory_peak_bytes_by_rank"] = of.memory;
  fit["input"] = of.input.string();
  fit["options"] = Json::parse(pipeline::options_json(of.options));
  fit["validation"] = {{"source", to_string(of.choice.source)}, {"patterns", of.choice.patterns}};
  fit["channels"] = channels;
  fit["warnings"] = warnings;
  return fit;
}

}  // namespace kappamu::app::mpi
