// What `kappamu bench forward --json` prints: the headline figures of a folder's records.
#include <nlohmann/json.hpp>

#include "bench/forward_bench.h"
#include "bench/forward_record.h"
#include "core/error.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

/// Of the whole solve, by the model of docs/engine.md; measured per kernel in section kernels.
double bandwidth_fraction(const Json& record, const Json& problem, const Sample& sample) {
  const double bandwidth = record.at("machine").at("copy_bandwidth_bytes_per_second").get<double>();
  return least_bytes(shape_of(problem).cells(), sample.patterns, sample.iterations,
                     sample.precision == "single" ? sizeof(float) : sizeof(double)) /
         (sample.solve_seconds_per_rhs * bandwidth);
}

Json summary_of_sample(const Sample& sample) {
  return {{"method", sample.method},
          {"precision", sample.precision},
          {"iterations", sample.iterations},
          {"seconds_per_rhs", sample.seconds_per_rhs},
          {"set_up_seconds", sample.set_up_seconds},
          {"true_error", sample.error()}};
}

/// Other people's solvers, as available_peers() names them.
bool is_peer(const std::string& method) {
  for (const char* library : {"hypre-", "petsc-", "eigen-"}) {
    if (method.rfind(library, 0) == 0) return true;
  }
  return false;
}

Json relaxation_claims(const std::filesystem::path& folder) {
  Json claims = Json::array();
  const auto record = record_of(folder, "relaxation");
  if (!record) return claims;
  const auto samples = samples_from_json(record->at("runs").at(0).at("samples"));
  for (const char* method : {"relaxation", "gauss-seidel"}) {
    const auto against = relaxation_ratio(samples, method);
    if (!against) continue;
    claims.push_back({{"method", method},
                      {"target_error", relaxation_error},
                      {"ours_seconds_per_rhs", against->ours_seconds},
                      {"ratio", against->ratio},
                      {"ratio_is_lower_bound", !against->reached}});
  }
  return claims;
}

Json kernel_claims(const std::filesystem::path& folder) {
  Json claims = Json::array();
  const auto record = record_of(folder, "kernels");
  if (!record) return claims;
  for (const Json& run : record->at("runs")) {
    for (const Json& profile : run.at("profiles")) claims.push_back(profile);
  }
  return claims;
}

}  // namespace

Json forward_summary(const std::filesystem::path& folder) {
  auto record = record_of(folder, "peers");
  if (!record) record = record_of(folder, "headline");
  if (!record) {
    Json rest{{"relaxation", relaxation_claims(folder)}, {"kernels", kernel_claims(folder)}};
    rest["sections"] = Json::array();
    for (const std::string& section : forward_sections()) {
      if (record_of(folder, section)) rest["sections"].push_back(section);
    }
    if (!rest["sections"].empty()) return rest;
    throw InputError(folder.string() +
                     " holds no record of a section; measure section peers or headline first.");
  }
  const Json& run = record->at("runs").at(0);
  const Json& problem = run.at("problem");
  const auto samples = samples_from_json(run.at("samples"));
  const Target target = target_of(samples);
  const auto single = samples_of(samples, "multigrid", "single");
  const Sample* best = cheapest_at_error(single, target.error);
  check(best != nullptr || !single.empty(), "forward_summary: no sample of ours");
  const Sample& chosen = best != nullptr ? *best : single.back();
  const auto ours = seconds_at_error(single, target.error);
  Json summary{{"grid", problem.at("grid")},
               {"patterns", problem.at("patterns")},
               {"contrast", problem.at("contrast")},
               {"background_contrast", problem.at("background_contrast")}};
  summary.update(summary_of_sample(chosen));
  summary["bandwidth_fraction"] = bandwidth_fraction(*record, problem, chosen);
  summary["target_error"] = target.error;
  summary["single_precision_floor"] = target.floor;
  summary["peers"] = Json::array();
  Json fastest;
  for (const Line& line : lines_of(samples)) {
    const Sample& any = line.samples.front();
    if (any.method == "multigrid") continue;
    const Sample* reached = cheapest_at_error(line.samples, target.error);
    const auto seconds = seconds_at_error(line.samples, target.error);
    if (reached == nullptr || !seconds || !ours) continue;
    Json peer = summary_of_sample(*reached);
    peer["setting"] = any.setting;
    peer["ratio"] = *seconds / *ours;
    if (is_peer(any.method) && (fastest.is_null() || peer["ratio"] < fastest["ratio"])) {
      fastest = peer;
    }
    summary["peers"].push_back(peer);
  }
  if (!fastest.is_null()) {
    summary["fastest_peer"] = fastest["method"];
    summary["fastest_peer_ratio"] = fastest["ratio"];
  }
  summary["relaxation"] = relaxation_claims(folder);
  summary["kernels"] = kernel_claims(folder);
  return summary;
}

}  // namespace kappamu::bench
