#include "studies/forward/comparison.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace kappamu::studies {

namespace {

constexpr double relaxation_error = 1e-2;

/// The samples of one method and precision.
std::vector<Sample> samples_of(const std::vector<Sample>& samples, const std::string& method,
                               const std::string& precision) {
  std::vector<Sample> some;
  for (const Sample& sample : samples) {
    if (sample.method == method && sample.precision == precision) some.push_back(sample);
  }
  return some;
}

Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json to_json(const Sample& sample) {
  Json object{{"method", sample.method},
              {"precision", sample.precision},
              {"tolerance", sample.tolerance},
              {"patterns", sample.patterns},
              {"iterations", sample.iterations},
              {"converged", sample.converged},
              {"set_up_seconds", sample.set_up_seconds},
              {"solve_seconds_per_rhs", sample.solve_seconds_per_rhs},
              {"seconds_per_rhs", sample.seconds_per_rhs},
              {"true_error", optional_json(sample.error())},
              {"error_of", sample.phi_error ? "phi" : "exitance"},
              {"map_error", optional_json(sample.map_error)}};
  if (!sample.setting.empty()) object["setting"] = sample.setting;
  return object;
}

Json short_json(const Sample& sample) {
  return {{"method", sample.method},
          {"precision", sample.precision},
          {"iterations", sample.iterations},
          {"seconds_per_rhs", sample.seconds_per_rhs},
          {"set_up_seconds", sample.set_up_seconds},
          {"true_error", optional_json(sample.error())}};
}

/// Other people's solvers.
bool is_peer(const std::string& method) {
  return method.starts_with("hypre-");
}

/// Seconds that a solver adds where one pattern pays its whole set-up.
double set_up_of_one(const Sample& sample) {
  return sample.set_up_seconds - (sample.seconds_per_rhs - sample.solve_seconds_per_rhs);
}

}  // namespace

Json to_json(const std::vector<Sample>& samples) {
  Json array = Json::array();
  for (const Sample& sample : samples) array.push_back(to_json(sample));
  return array;
}

std::string grid_name(const GridShape& shape) {
  return std::to_string(shape.nx) + "x" + std::to_string(shape.ny) + "x" + std::to_string(shape.nz);
}

double least_bytes(std::size_t cells, int lanes, int iterations, std::size_t real_bytes) {
  constexpr double coarse_cells = 1.0 / 7.0;
  constexpr double vectors = 5.0 + 5.0 * coarse_cells, coefficients = 21.0 + 16.0 * coarse_cells;
  return static_cast<double>(cells) * static_cast<double>(real_bytes) *
         (vectors + coefficients / lanes) * iterations;
}

Json compare(const std::vector<Sample>& samples, std::size_t cells, double copy_bandwidth) {
  const std::vector<Sample> single = samples_of(samples, "multigrid", "single");
  check(!single.empty(), "compare: no sample of ours");
  double floor = 1.0;
  for (const Sample& sample : single) floor = std::min(floor, sample.error().value_or(1.0));
  const double target = floor > 1e-6 ? 1e-5 : 1e-6;
  const Sample* best = cheapest_at_error(single, target);
  const Sample& chosen = best != nullptr ? *best : single.back();
  const auto ours = seconds_at_error(single, target);
  Json result = short_json(chosen);
  result["bandwidth_fraction"] =
      least_bytes(cells, chosen.patterns, chosen.iterations, sizeof(float)) /
      (chosen.solve_seconds_per_rhs * copy_bandwidth);
  result["target_error"] = target;
  result["single_precision_floor"] = floor;
  result["solvers"] = result["peers"] = Json::array();
  std::vector<std::pair<std::string, std::string>> seen;
  double fastest = HUGE_VAL;
  for (const Sample& sample : samples) {
    const std::pair key(sample.method, sample.precision);
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) continue;
    seen.push_back(key);
    const std::vector<Sample> own = samples_of(samples, sample.method, sample.precision);
    const auto seconds = seconds_at_error(own, target);
    Json solver{{"method", sample.method}, {"precision", sample.precision}, {"seconds", nullptr}};
    if (seconds && ours) {
      const double unshared = *seconds + set_up_of_one(sample);
      solver["seconds"] = *seconds;
      solver["ratio"] = *seconds / *ours;
      solver["unshared_seconds"] = unshared;
      solver["unshared_ratio"] = unshared / (*ours + set_up_of_one(single.front()));
      if (sample.method != "multigrid") {
        Json peer = short_json(*cheapest_at_error(own, target));
        peer["setting"] = sample.setting;
        peer["ratio"] = solver["ratio"];
        result["peers"].push_back(peer);
      }
      if (is_peer(sample.method) && *seconds / *ours < fastest) {
        fastest = *seconds / *ours;
        result["fastest_peer"] = sample.method;
        result["fastest_peer_ratio"] = fastest;
      }
    }
    result["solvers"].push_back(solver);
  }
  return result;
}

Json compare_relaxation(const std::vector<Sample>& samples) {
  Json claims = Json::array();
  const auto ours = seconds_at_error(samples_of(samples, "multigrid", "single"), relaxation_error);
  for (const char* method : {"relaxation", "gauss-seidel"}) {
    const std::vector<Sample> own = samples_of(samples, method, "single");
    if (own.empty() || !ours) continue;
    const auto seconds = seconds_at_error(own, relaxation_error);
    const Sample& last = own.back();
    claims.push_back({{"method", method},
                      {"target_error", relaxation_error},
                      {"ours_seconds_per_rhs", *ours},
                      {"ratio", seconds.value_or(last.seconds_per_rhs) / *ours},
                      {"ratio_is_lower_bound", !seconds.has_value()},
                      {"last_seconds", last.seconds_per_rhs},
                      {"last_error", optional_json(last.error())}});
  }
  return claims;
}

}  // namespace kappamu::studies
