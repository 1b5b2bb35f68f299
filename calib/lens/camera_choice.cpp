#include "calib/lens/camera_choice.h"

#include <algorithm>
#include <cmath>

namespace kappamu::calib {
namespace {

constexpr double needed_of_high_order = 2.0;  // standard errors
constexpr double needed_of_fewer = 2.0;
constexpr double needed_of_bend = 1.0;
constexpr double tolerance = 1e-9;  // relative, of the sum of squares: to compare models
constexpr int iterations = 60;      // idle coefficients of rich models creep for hundreds

struct Candidate {
  CameraFit fit;
  std::vector<HeldOutView> held_out;

  double mean_square() const {
    double sum = 0.0;
    int corners = 0;
    for (const HeldOutView& view : held_out) {
      sum += view.square;
      corners += view.corners;
    }
    return sum / corners;
  }
};

/// How many standard errors (of the sum over views) `richer` lies below `simpler`.
double deviations_won(const Candidate& simpler, const Candidate& richer) {
  const auto views = static_cast<double>(simpler.held_out.size());
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t v = 0; v < simpler.held_out.size(); ++v) {
    const double gain = simpler.held_out[v].square - richer.held_out[v].square;
    sum += gain;
    squares += gain * gain;
  }
  const double variance = (squares - sum * sum / views) * views / (views - 1.0);
  return sum / std::sqrt(std::max(variance, 1e-300));
}

/// The sequence of models for a flat or a bent board.
struct Sequence {
  std::vector<Candidate> candidates;
  std::size_t best = 0;
};

Sequence climb(const CameraSetting& setting, CameraFit start, Bend bend, LensModel last_model) {
  Sequence sequence;
  std::fill(start.numbers.begin() + 4, start.numbers.end(), 0.0);
  for (const LensModel model :
       {LensModel::pinhole, LensModel::radial1, LensModel::radial2, LensModel::radial2_tangential,
        LensModel::full, LensModel::rational}) {
    CameraProblem problem(setting, start, model, bend);
    problem.solve(tolerance, iterations);
    sequence.candidates.push_back({problem.fit(), problem.leave_one_out()});
    start = problem.fit();
    const std::size_t last = sequence.candidates.size() - 1;
    const Candidate& candidate = sequence.candidates[last];
    const Candidate& best = sequence.candidates[sequence.best];
    const bool high_order = model == LensModel::full || model == LensModel::rational;
    const double won = deviations_won(best, candidate);
    if (high_order ? won > needed_of_high_order : won > -needed_of_fewer) sequence.best = last;
    if (model == last_model) break;
  }
  return sequence;
}

}  // namespace

CameraChoice choose_camera(const CameraSetting& setting, const CameraFit& start) {
  const Sequence flat = climb(setting, start, Bend::none, LensModel::rational);
  const Sequence bent = climb(setting, start, Bend::free, flat.candidates[flat.best].fit.model);
  const Candidate& best_flat = flat.candidates[flat.best];
  const Candidate& best_bent = bent.candidates[bent.best];
  const bool bend = deviations_won(best_flat, best_bent) > needed_of_bend;
  CameraChoice choice;
  choice.fit = bend ? best_bent.fit : best_flat.fit;
  for (const Sequence* sequence : {&flat, &bent}) {
    for (const Candidate& candidate : sequence->candidates) {
      const CameraFit& fit = candidate.fit;
      choice.scores.push_back({fit.model, fit.bent, std::sqrt(candidate.mean_square()),
                               fit.model == choice.fit.model && fit.bent == choice.fit.bent});
    }
  }
  return choice;
}

}  // namespace kappamu::calib
