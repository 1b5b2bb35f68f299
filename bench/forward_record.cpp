#include "bench/forward_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

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
  constexpr double half_vectors = 10.0, coefficients = 5.0, sweeps = 3.0, all_levels = 8.0 / 7.0;
  const double per_cell = 0.5 * half_vectors + coefficients * sweeps / lanes;
  return static_cast<double>(cells) * static_cast<double>(real_bytes) * per_cell * all_levels *
         iterations;
}

}  // namespace kappamu::bench
