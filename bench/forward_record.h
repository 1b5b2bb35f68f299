// Samples in and out of the records of `kappamu bench forward`.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure.h"

namespace kappamu::bench {

nlohmann::ordered_json to_json(const Sample& sample);
nlohmann::ordered_json to_json(const std::vector<Sample>& samples);
std::vector<Sample> samples_from_json(const nlohmann::ordered_json& array);

/// The record of a section in `folder`; nothing where that section was not measured. Throws as
/// read_record() does.
std::optional<nlohmann::ordered_json> record_of(const std::filesystem::path& folder,
                                                const std::string& section);

/// Grid and voxel of a record's problem.
GridShape shape_of(const nlohmann::ordered_json& problem);

/// The samples of one method, of one precision or of both.
std::vector<Sample> samples_of(const std::vector<Sample>& samples, const std::string& method,
                               const std::string& precision = "");

/// The error at which the sides are compared: 1e-6, or 1e-5 where single precision ends above 1e-6.
struct Target {
  double error = 1e-6;
  double floor = 1.0;  ///< least error single precision attained
};
Target target_of(const std::vector<Sample>& samples);

/// Ours against a method at a true error of 1e-2.
struct RelaxationRatio {
  double ours_seconds = 0.0;  ///< per right-hand side
  double ratio = 0.0;         ///< the method's seconds over ours
  bool reached = false;       ///< or the ratio is a lower bound: its last sample was not there yet
  double last_error = 0.0, last_seconds = 0.0;  ///< of its last sample
};
inline constexpr double relaxation_error = 1e-2;
/// Nothing where either has no sample.
std::optional<RelaxationRatio> relaxation_ratio(const std::vector<Sample>& samples,
                                                const std::string& method);

/// Samples grouped by method and precision, in order of first appearance: the lines of a chart.
struct Line {
  std::string label;
  std::vector<Sample> samples;
};
std::vector<Line> lines_of(const std::vector<Sample>& samples);

/// "256x256x20"
std::string grid_name(const GridShape& shape);

/// Bytes that `iterations` of our conjugate gradients must move between memory and cores for one of
/// `lanes` patterns, coarser grids included: the table of docs/engine.md.
double least_bytes(std::size_t cells, int lanes, int iterations, std::size_t real_bytes);

}  // namespace kappamu::bench
