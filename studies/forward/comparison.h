// Samples of `kappamu-studies forward` as JSON, and what they say of one another: times at equal
// true error.
#pragma once

#include <string>
#include <vector>

#include "studies/forward/measure.h"
#include "studies/record.h"

namespace kappamu::studies {

Json to_json(const std::vector<Sample>& samples);

/// "256x256x20"
std::string grid_name(const GridShape& shape);

/// Bytes that `iterations` of our conjugate gradients must move between memory and cores for one of
/// `lanes` patterns, coarser grids included: the table of docs/engine.md.
double least_bytes(std::size_t cells, int lanes, int iterations, std::size_t real_bytes);

/// All solvers at the error where sides are compared: 1e-6, or 1e-5 where single precision ends
/// above 1e-6. Ours: method, precision, iterations, seconds_per_rhs, set_up_seconds, true_error,
/// bandwidth_fraction (least_bytes() over seconds and `copy_bandwidth` [bytes/s]), target_error,
/// single_precision_floor. solvers: of each method and precision its seconds interpolated to that
/// error, with the set-up shared by all patterns and paid by one, and their ratios to ours; null
/// where it is not reached. peers: all but ours, of the cheapest sample there; fastest_peer and
/// fastest_peer_ratio among other people's.
Json compare(const std::vector<Sample>& samples, std::size_t cells, double copy_bandwidth);

/// Ours against the papers' relaxations at a true error of 1e-2: ratio, or its lower bound where
/// the last sample is not there yet.
Json compare_relaxation(const std::vector<Sample>& samples);

}  // namespace kappamu::studies
