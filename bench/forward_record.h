// Samples in and out of the records of `kappamu bench forward`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/measure.h"

namespace kappamu::bench {

nlohmann::ordered_json to_json(const Sample& sample);
nlohmann::ordered_json to_json(const std::vector<Sample>& samples);
std::vector<Sample> samples_from_json(const nlohmann::ordered_json& array);

/// Samples grouped by method and precision, in order of first appearance: the lines of a chart.
struct Line {
  std::string label;
  std::vector<Sample> samples;
};
std::vector<Line> lines_of(const std::vector<Sample>& samples);

/// "256x256x20"
std::string grid_name(const GridShape& shape);

/// Bytes that `iterations` of our conjugate gradients must move between memory and cores for one of
/// `lanes` patterns. Vectors of conjugate gradients hold half of the cells (red-black reduction):
/// per iteration d, r and p are read and written, r is read again by the V-cycle, and z written and
/// read twice on its way down and up, ten half vectors; the coefficients (three conductances, sink,
/// smoother) are read once by each of three sweeps and shared by the lanes; coarser grids add 1/7.
double least_bytes(std::size_t cells, int lanes, int iterations, std::size_t real_bytes);

}  // namespace kappamu::bench
