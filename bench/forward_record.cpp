#include "bench/forward_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/record.h"

namespace kappamu::bench {

using Json = nlohmann::ordered_json;

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
              {"true_error", sample.error()},
              {"error_of", sample.phi_error ? "phi" : "exitance"},
              {"map_error", sample.map_error}};
  if (!sample.setting.empty()) object["setting"] = sample.setting;
  return object;
}

Json to_json(const std::vector<Sample>& samples) {
  Json array = Json::array();
  for (const Sample& sample : samples) array.push_back(to_json(sample));
  return array;
}

std::vector<Sample> samples_from_json(const Json& array) {
  std::vector<Sample> samples;
  for (const Json& object : array) {
    Sample sample;
    sample.method = object.at("method").get<std::string>();
    sample.precision = object.at("precision").get<std::string>();
    sample.setting = object.value("setting", "");
    sample.tolerance = object.at("tolerance").get<double>();
    sample.patterns = object.at("patterns").get<int>();
    sample.iterations = object.at("iterations").get<int>();
    sample.converged = object.at("converged").get<bool>();
    sample.set_up_seconds = object.at("set_up_seconds").get<double>();
    sample.solve_seconds_per_rhs = object.at("solve_seconds_per_rhs").get<double>();
    sample.seconds_per_rhs = object.at("seconds_per_rhs").get<double>();
    sample.map_error = object.at("map_error").get<double>();
    if (object.at("error_of") == "phi") sample.phi_error = object.at("true_error").get<double>();
    samples.push_back(sample);
  }
  return samples;
}

std::optional<Json> record_of(const std::filesystem::path& folder, const std::string& section) {
  const std::filesystem::path file = folder / ("forward-" + section + ".json");
  if (!std::filesystem::exists(file)) return std::nullopt;
  return read_record(file, "forward-" + section);
}

GridShape shape_of(const Json& problem) {
  const Json& n = problem.at("grid");
  return {n[0].get<int>(), n[1].get<int>(), n[2].get<int>(), problem.value("voxel_mm", 1.0)};
}

std::vector<Sample> samples_of(const std::vector<Sample>& samples, const std::string& method,
                               const std::string& precision) {
  std::vector<Sample> some;
  for (const Sample& sample : samples) {
    if (sample.method == method && (precision.empty() || sample.precision == precision)) {
      some.push_back(sample);
    }
  }
  return some;
}

Target target_of(const std::vector<Sample>& samples) {
  Target target;
  for (const Sample& sample : samples_of(samples, "multigrid", "single")) {
    target.floor = std::min(target.floor, sample.error());
  }
  if (target.floor > target.error) target.error = 1e-5;
  return target;
}

std::optional<RelaxationRatio> relaxation_ratio(const std::vector<Sample>& samples,
                                                const std::string& method) {
  const auto ours = seconds_at_error(samples_of(samples, "multigrid", "single"), relaxation_error);
  const auto own = samples_of(samples, method);
  if (own.empty() || !ours) return std::nullopt;
  const auto seconds = seconds_at_error(own, relaxation_error);
  const Sample& last = own.back();
  return RelaxationRatio{*ours, seconds.value_or(last.seconds_per_rhs) / *ours, seconds.has_value(),
                         last.error(), last.seconds_per_rhs};
}

std::vector<Line> lines_of(const std::vector<Sample>& samples) {
  std::vector<Line> lines;
  for (const Sample& sample : samples) {
    std::string label = sample.method;
    if (sample.method == "multigrid") label = "kappamu, " + sample.precision;
    if (sample.method == "reference") label = "kappamu's serial reference";
    if (!sample.phi_error) label += " (maps)";
    const auto found = std::find_if(lines.begin(), lines.end(),
                                    [&](const Line& line) { return line.label == label; });
    if (found == lines.end()) {
      lines.push_back({label, {sample}});
    } else {
      found->samples.push_back(sample);
    }
  }
  return lines;
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

}  // namespace kappamu::bench
