// One fit of a known block, measured: what it cost and how its volume looks under light it never
// saw, along its course and at its end.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/inverse_case.h"
#include "core/progress.h"
#include "inverse/fit/fit.h"

namespace kappamu::bench {

/// A named way to fit.
struct Way {
  std::string name;   ///< in records: "default", "wang2008-scheme", ...
  std::string label;  ///< in legends and tables
  inverse::FitOptions options;
  /// [W]: one fixed weight. The one the default ended with is taken, which no user of [W] knows.
  bool weight_of_default = false;
};

/// The default first; then L-BFGS in other coordinates, and [W]'s optimiser along our course and
/// in the paper's own scheme (one grid, homogeneous start, fixed weight).
std::vector<Way> inverse_ways();

/// What a fit is judged by: light it does not see, and the block's own fields.
struct Judge {
  SurfaceMeasurements patches;           ///< 8 × 8 patches
  SurfaceMeasurements single;            ///< a sample of single-voxel sources
  inverse::CoefficientPair fine_fields;  ///< on the grid of the data
};
Judge make_judge(const Block& block, inverse::CoefficientPair fine_fields, int single_sources = 64);

/// A point of the course. The volume is what would be exported there: interpolated to the fitted
/// grid.
struct CoursePoint {
  int solves = 0;        ///< batched solves of all patterns on whatever grid
  double work = 0.0;     ///< voxel iterations over the fitted grid's voxels
  double seconds = 0.0;  ///< since the start, scoring left out
  double weight = 0.0;   ///< α
  double chi2 = 0.0;     ///< per datum, of the grid fitted at that point
  int level = 0;         ///< 0 = the fitted grid itself
  double error = 0.0;    ///< E under 8 × 8 patches
};

/// Median of |found/true − 1| over each layer, lit face first; the truth averaged over the fitted
/// voxel.
struct DepthError {
  std::vector<double> kappa;
  std::vector<double> mu;
};
DepthError depth_error(const Medium& medium, const inverse::CoefficientPair& fine_fields,
                       Face lit_face);

struct FitScore {
  std::string way;
  GridShape grid;
  int patterns = 0;
  double noise = 0.0;
  std::string status;
  std::string backend;
  int solves = 0;
  double work = 0.0;
  double seconds = 0.0;
  double chi2 = 0.0;
  double weight = 0.0;
  double patches_error = 0.0;  ///< E, 8 × 8 patches
  double single_error = 0.0;   ///< E, single-voxel sources
  DepthError depth;
  std::vector<CoursePoint> course;  ///< empty unless asked for
};

/// Whether the fit is judged by some of its patterns first, as `kappamu fit` does unless told
/// otherwise (inverse/fit/validated_fit.h): a cost that a comparison of optimisers leaves out.
enum class Judged { no, by_own_patterns };

/// Fits channel 0. `course_points`: at most about so many points of the course are scored, evenly
/// over the logarithm of the solves.
FitScore measure_fit(const SurfaceMeasurements& measurements, const Judge& judge,
                     const inverse::FitOptions& options, Judged judged, int course_points,
                     Progress& progress);

/// Where the course first has an E of at most `error`; null where it never does.
const CoursePoint* first_to_reach(const std::vector<CoursePoint>& course, double error);

nlohmann::ordered_json to_json(const FitScore& score);
FitScore fit_score_from_json(const nlohmann::ordered_json& object);

}  // namespace kappamu::bench
