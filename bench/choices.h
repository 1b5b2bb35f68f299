// `kappamu bench choices`: what the fit's choices cost or gain in E under light it never saw:
// patterns held out, the regulariser, the loss where pixels are wild. The medians behind the
// defaults of inverse/fit/fit.h (docs/theory.md, section 4).
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kappamu::bench {

struct ChoicesOptions {
  std::string device = "auto";
  std::vector<double> noise{0.003, 0.01, 0.03};  ///< relative
  int truths = 3;                                ///< of choice_truths(), at most all of them
  int seeds = 1;                                 ///< of the noise, per truth
  std::uint64_t seed = 1;
};

/// held-out, regulariser, loss.
const std::vector<std::string>& choice_subjects();

struct ChoiceScore {
  std::string way;    ///< "1 of 16 held out", "huber-tv, t = 2", ...
  std::string truth;  ///< "boxes", "smooth", "layers"
  double noise = 0.0;
  std::uint64_t seed = 0;
  double patches_error = 0.0;  ///< E, 8 × 8 patches
  double single_error = 0.0;   ///< E, single-voxel sources
  double kappa_error = 0.0;    ///< median |found/true − 1| over the layers
  double mu_error = 0.0;
  double chi2 = 0.0;    ///< per datum fitted
  double weight = 0.0;  ///< α at the end
  int solves = 0;       ///< batched
};

/// Fits every truth, noise and seed in every way of the subject, interleaved; a volume always,
/// since models of few unknowns have none of these choices. Throws InputError for an unknown
/// subject.
std::vector<ChoiceScore> measure_choices(const std::string& subject, const ChoicesOptions& options,
                                         Progress& progress);

/// Median and worst E of each way at each noise, as a table of Markdown.
std::string choices_table(const std::vector<ChoiceScore>& scores);

/// Median E under 8 × 8 patches and median error of κ against noise, a line for each way.
void draw_choices(const std::vector<ChoiceScore>& scores, const std::filesystem::path& png);

nlohmann::ordered_json choices_record(const std::string& subject, const ChoicesOptions& options,
                                      const std::vector<ChoiceScore>& scores);

}  // namespace kappamu::bench
