#include "inverse/block_model/model_choice.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "inverse/block_model/model_evidence.h"
#include "inverse/block_model/systematic_error.h"
#include "inverse/defaults.h"
#include "inverse/optimise/settle_correction.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::model_choice;

/// The same layers in slices of half the depth.
LayeredMedium halved_slices(LayeredMedium medium) {
  for (int& first : medium.first) first *= 2;
  return medium;
}

/// All trials on one grid.
class Level {
 public:
  Level(const GridLevels& levels, int level, const ModelSearchOptions& options)
      : options_(options),
        level_(level),
        model_error_(level == 0 ? options.model_error : options.coarse_model_error),
        objective_(levels[level], options.backend) {
    if (options.correct_grid) refinement_ = levels.refinement(level);
  }

  int depth() const { return objective_.space().depth(); }
  std::size_t used() const { return objective_.problem().used(); }
  int most_layers() const { return std::min(depth(), defaults::model_choice::most_layers); }
  const SolveCount& solves() const { return objective_.solves(); }

  /// r at `medium` is known.
  void set_correction(const LayeredMedium& medium, const Correction& correction) {
    objective_.set_correction(correction);
    corrected_at_ = fields(medium);
  }

  SimpleFit fit(const LayeredMedium& start) {
    refresh(start);
    LayerFitter fitter(objective_, start);
    LayeredFit found;
    found.medium = start;
    if (refinement_.photons) {
      const double far = options_.asked == Model::automatic
                             ? far_off * chi2_limit(used(), tolerated)
                             : std::numeric_limits<double>::infinity();
      double lowest = std::numeric_limits<double>::infinity();
      settle_correction(unknowns(start), settled_move, most_by_transport,
                        [&](const Eigen::VectorXd& p) {
                          // If the solver fails or χ² is far too large, the last fit stands and is
                          // rejected.
                          if (!try_to_refresh(with_unknowns(start, p))) return p;
                          const double chi2 = objective_.chi2_per_value();
                          if (chi2 > std::max(far, no_gain * lowest)) return p;
                          lowest = std::min(lowest, chi2);
                          fitter.forget_derivatives();
                          found = fitter.descend(useful());
                          return unknowns(found.medium);
                        });
    } else {
      found = fitter.descend(useful());
      for (int k = 1; options_.correct_grid && k < most_corrections; ++k) {
        const double chi2 = refresh(found.medium);
        if (std::abs(chi2 - found.chi2_per_value) <= settled * found.chi2_per_value) break;
        found = fitter.descend(useful());
      }
    }
    SimpleFit simple;
    simple.normal = fitter.normal();
    simple.fields = fields(found.medium);
    objective_.value(simple.fields);
    simple.correction = objective_.correction();
    simple.prediction = objective_.prediction();
    const Evidence evidence = weigh(objective_.problem(), simple.prediction, model_error_);
    ModelTrial& trial = simple.trial;
    trial.layers = found.medium.layers();
    trial.model = trial.layers == 1 ? Model::homogeneous : Model::layered;
    trial.level = level_;
    trial.chi2_per_value = evidence.chi2_per_value;
    trial.coherent = evidence.coherent();
    trial.coherent_limit = coherent_limit(evidence, tolerated);
    trial.rejected = !not_rejected(evidence, tolerated);
    simple.medium = std::move(found.medium);
    if (level_ == 0) {
      simple.systematic = estimate_systematic_error(
          objective_.problem(), {simple.prediction, simple.correction.ratio, !refinement_.photons});
      const ErrorCovariance errors(objective_.problem(), simple.prediction, simple.systematic,
                                   common_error);
      simple.slope = fitter.slope_covariance(errors);
      simple.residual = fitter.residual_without_common(errors);
    }
    return simple;
  }

  /// Whether what `last`, fitted last, leaves beyond noise is error of the data and no structure.
  bool unstructured(const SimpleFit& last) {
    const SystematicError& error = last.systematic;
    if (error.excess > most_systematic) return false;
    const Problem& problem = objective_.problem();
    const ErrorCovariance errors(problem, last.prediction, error, 0.0);
    return structure_ratio(objective_, last.residual, errors, draws, options_.seed) <=
           most_structure;
  }

 private:
  CoefficientPair fields(const LayeredMedium& medium) const {
    return to_fields(medium, objective_.space());
  }
  /// χ² per value with the correction at `medium`.
  double refresh(const LayeredMedium& medium) {
    CoefficientPair at = fields(medium);
    if (!options_.correct_grid || at == corrected_at_) {
      objective_.value(at);
    } else {
      objective_.refresh_correction(refinement_, at, Objective::PhotonSlope::renewed);
      corrected_at_ = std::move(at);
    }
    return objective_.chi2_per_value();
  }
  bool try_to_refresh(const LayeredMedium& medium) {
    try {
      refresh(medium);
      return true;
    } catch (const InputError&) {
      return false;
    }
  }
  /// χ² per value that a model of this grid may have: coarse grids only screen.
  double useful() const {
    // r by photons is accurate only at the end of the fit.
    const bool screens = level_ > 0 && options_.asked == Model::automatic && !refinement_.photons;
    return screens ? chi2_limit(used(), tolerated) : 0.0;
  }

  const ModelSearchOptions& options_;
  int level_;
  ModelError model_error_;
  Objective objective_;
  Refinement refinement_;
  CoefficientPair corrected_at_;  ///< where r was made; empty before the first
};

std::string name_of(int layers) {
  return layers == 1 ? "a homogeneous block" : std::to_string(layers) + " layers";
}

class Search {
 public:
  Search(const GridLevels& levels, double kappa, double mu, const Correction& correction,
         const ModelSearchOptions& options, const std::function<void(const std::string&)>& on_trial)
      : levels_(levels),
        correction_(correction),
        options_(options),
        on_trial_(on_trial),
        best_{{0}, {std::log(kappa)}, {std::log(mu)}} {}

  ModelSearch run() {
    for (int level = levels_.coarsest(); level >= 0; --level) {
      Level grid(levels_, level, options_);
      if (level == levels_.coarsest()) grid.set_correction(best_, correction_);
      const bool plausible = level > 0 ? screen(grid) : decide(grid);
      search_.solves.add(grid.solves());
      if (!plausible) break;
      best_ = halved_slices(std::move(best_));
    }
    return std::move(search_);
  }

 private:
  /// Whether the finer grid should be asked.
  bool screen(Level& grid) {
    if (options_.asked == Model::homogeneous) return best_of(grid, 1), true;
    if (!best_of(grid, 1).trial.rejected) return true;
    if (grid.most_layers() == 1) return true;
    return !best_of(grid, grid.most_layers()).trial.rejected || options_.asked == Model::layered;
  }

  /// On the finest grid.
  bool decide(Level& grid) {
    if (offer(grid, 1) || options_.asked == Model::homogeneous) return accept_last();
    const int most = grid.most_layers();
    if (most > 1) offer(grid, most);
    SimpleFit& last = search_.rejected.back();
    if (last.trial.rejected && grid.unstructured(last)) {
      search_.systematic = last.systematic;
      last.trial.rejected = false;
      search_.trials.back() = last.trial;
    }
    if (last.trial.rejected) return options_.asked == Model::layered && accept_last();
    if (most > 1) merge(grid);
    return accept_last();
  }

  /// The last fit with as few layers as the data need, one of them the homogeneous block that noise
  /// alone rejects: layers explain systematic errors too, to a part that chance_rise() knows.
  void merge(Level& grid) {
    const SimpleFit all = search_.rejected.back();
    const auto used = static_cast<double>(grid.used());
    const auto needless = [&](const SimpleFit& fewer) {
      const ChanceRise chance =
          chance_rise(all.normal, all.slope, copies(all.medium, fewer.medium));
      const double rise = used * (fewer.trial.chi2_per_value - all.trial.chi2_per_value);
      return rise <=
             2.0 * tolerated_rise * used + chance.mean + chance_deviations * chance.deviation;
    };
    if (options_.asked != Model::layered && needless(search_.rejected.front())) {
      search_.rejected.pop_back();
      ModelTrial& one = search_.rejected.back().trial;
      one.rejected = false;
      (search_.trials.end() - 2)->rejected = false;
      search_.systematic = search_.rejected.back().systematic;
      return;
    }
    // (H⁻¹ S H⁻¹)⁻¹: what apart are errors of the data does not keep layers apart.
    const Eigen::MatrixXd certain = all.normal * solve_symmetric(all.slope, all.normal);
    const LayeredMedium fewer = merge_layers(all.medium, certain, tolerated_rise * used);
    if (fewer.layers() == all.medium.layers()) return;
    SimpleFit merged = tried(grid, fewer);
    merged.trial.rejected = !needless(merged);
    search_.trials.back() = merged.trial;
    if (!merged.trial.rejected) search_.rejected.back() = std::move(merged);
  }

  /// True where the data do not reject it.
  bool offer(Level& grid, int layers) {
    search_.rejected.push_back(best_of(grid, layers));
    return !search_.rejected.back().trial.rejected;
  }
  bool accept_last() {
    search_.accepted = std::move(search_.rejected.back());
    search_.rejected.pop_back();
    return true;
  }

  SimpleFit best_of(Level& grid, int layers) {
    return tried(grid, with_layers(best_, layers, grid.depth()));
  }
  SimpleFit tried(Level& grid, const LayeredMedium& start) {
    on_trial_(name_of(start.layers()));
    SimpleFit fit = grid.fit(start);
    search_.trials.push_back(fit.trial);
    best_ = fit.medium;
    return fit;
  }

  const GridLevels& levels_;
  const Correction& correction_;
  const ModelSearchOptions& options_;
  const std::function<void(const std::string&)>& on_trial_;
  LayeredMedium best_;  ///< of the last trial, in slices of the grid at hand
  ModelSearch search_;
};

}  // namespace

ModelSearch search_simple_models(const GridLevels& levels, double kappa, double mu,
                                 const Correction& correction, const ModelSearchOptions& options,
                                 const std::function<void(const std::string&)>& on_trial) {
  return Search(levels, kappa, mu, correction, options, on_trial).run();
}

}  // namespace kappamu::inverse
