#include "inverse/distributed/distributed_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "inverse/defaults.h"
#include "inverse/distributed/piece_function.h"
#include "inverse/fit/conclusion.h"
#include "inverse/fit/path_rules.h"
#include "inverse/problem/grid_path.h"

namespace kappamu::inverse::distributed {

namespace {

/// One weight.
struct PieceStage {
  CoefficientPair begun;
  LateralBlocks blocks;         ///< the data's Hessian there, of this rank's bins
  LateralBlocks scaled_blocks;  ///< as the optimiser's coordinates have it
  std::unique_ptr<Basis> basis;
  std::unique_ptr<PieceFunction> function;
  OptimiserState optimiser;
  double chi2 = 0.0;
  double corrected_chi2 = 0.0;  ///< where r was made
  int steps = 0, small_decreases = 0;
  bool ran_out = false;
};

class PiecePath {
 public:
  PiecePath(const PieceGrid& data, const FitOptions& options, const PathCheckpoint& checkpoint,
            Progress& progress, const PieceContext& context)
      : options_(options),
        checkpoint_(checkpoint),
        progress_(progress),
        context_(context),
        levels_(piece_levels(data, options.data.coarse_model_error, options.path.max_levels)),
        closer_(closer_of(levels_, options.data.coarse_model_error)) {}

  PieceFit run();

 private:
  void begin();
  void begin_continued(const PieceContinuation& from);
  void open(int level, bool closer = false);
  void begin_grid(double weight);
  void begin_next_grid();
  void keep_pairs();
  void begin_weight();
  void repeat_weight();
  void update_correction();
  bool correction_is_outdated() const;
  void minimise();
  Minimum settle();
  Outlook outlook(double chi2) const;
  void descend();
  void record();
  void save();

  bool fixed_weight() const { return options_.path.weight.has_value(); }
  double seconds() const { return seconds_before_ + watch_.seconds(); }
  const BlockPieces& pieces() const { return objective_->pieces(); }
  MediumSpace whole_space() const {
    return forward::block_space(pieces().whole().shape, pieces().whole().lit_face);
  }
  AbsorptionScale scale() const {
    return AbsorptionScale(defaults::little_absorption * state_.report.homogeneous_mu);
  }
  Basis basis_of(double weight, const LateralBlocks& blocks, double slope, double damping) const;

  const FitOptions& options_;
  const PathCheckpoint& checkpoint_;
  Progress& progress_;
  const PieceContext& context_;
  std::vector<PieceGrid> levels_;
  std::optional<PieceGrid> closer_;  ///< of level 1
  PathState state_;
  std::unique_ptr<PieceObjective> objective_;
  std::shared_ptr<const PieceWaves> waves_;
  PieceStage stage_;
  Stopwatch watch_;
  double seconds_before_ = 0.0;
  double shared_error_ = 0.0;  ///< shared_error() of minimise.h
};

void PiecePath::open(int level, bool closer) {
  const SolveCount before = objective_ ? objective_->solves() : state_.report.solves;
  const PieceGrid& grid = closer ? *closer_ : levels_[static_cast<std::size_t>(level)];
  FitReport& report = state_.report;
  const double thickness = grid.pieces->whole().thickness_mm();
  const Anchor anchor{std::log(report.homogeneous_kappa), std::log(report.homogeneous_mu),
                      options_.regulariser.anchor_length * thickness};
  PieceRefinement finer;
  if (options_.path.correct_grid) {
    finer =
        piece_refinement(grid, level > 0 ? &levels_[static_cast<std::size_t>(level) - 1] : nullptr);
  }
  const Backend backend = as_loose_as_data(options_.solver.backend, grid);
  objective_ = std::make_unique<PieceObjective>(
      grid, std::move(finer), backend, options_.data.term, anchor,
      Regulariser{options_.regulariser.kind, options_.regulariser.edge_slope});
  objective_->set_derivative_tolerance(derivative_tolerance(backend));
  objective_->count(before);
  waves_ = std::make_shared<PieceWaves>(*grid.pieces);
  stage_ = {};
  state_.level = level;
  state_.closer = closer;
  shared_error_ = 0.5 * defaults::least_of_light * signal_square(grid);
  if (!objective_->shares_errors()) shared_error_ = 0.0;
}

void PiecePath::begin_grid(double weight) {
  state_.weight = weight;
  state_.last = state_.level == 0 && fixed_weight() && !context_.interim;
  state_.end = PathEnd::unknown;
  state_.last_chi2 = state_.last_score = 0.0;
}

/// From level 1 to itself closer, or to the next finer grid: fit/fit.cpp.
void PiecePath::begin_next_grid() {
  const bool closer = state_.level == 1 && !state_.closer && closer_.has_value();
  if (!closer) {
    state_.own =
        to_finer(state_.own, pieces(), *levels_[static_cast<std::size_t>(state_.level) - 1].pieces);
  }
  open(closer ? 1 : state_.level - 1, closer);
  const double chi2 = objective_->renew_correction(state_.own);
  begin_grid(weight_on_finer_grid(options_.path, state_.weight, chi2));
}

void PiecePath::begin() {
  FitReport& report = state_.report;
  std::optional<HomogeneousGuess> guess;
  if (options_.path.start_kappa) guess = {*options_.path.start_kappa, *options_.path.start_mu};
  const HomogeneousFit start = find_start(levels_.front(), guess);
  report.homogeneous_kappa = start.kappa;
  report.homogeneous_mu = start.mu;
  report.homogeneous_log_residual = start.log_residual;
  report.model.model = Model::volume;
  report.model.reason = "kappamu-mpi fits volumes alone";
  if (!start.converged) {
    report.warnings.emplace_back(
        "The homogeneous start did not converge; the volumes may depend on where it stopped.");
  }
  open(static_cast<int>(levels_.size()) - 1);
  const std::size_t cells = pieces().owned().cells();
  state_.own = {Vector(cells, std::log(start.kappa)), Vector(cells, std::log(start.mu))};
  begin_grid(first_weight(options_.path, objective_->renew_correction(state_.own)));
}

void PiecePath::begin_continued(const PieceContinuation& from) {
  state_.report = from.report;
  seconds_before_ = from.report.seconds;
  state_.own = from.own;
  open(0);
  begin_grid(weight_going_on(options_.path, from.report.weight));
  objective_->renew_correction(state_.own);
}

Basis PiecePath::basis_of(double weight, const LateralBlocks& blocks, double slope,
                          double damping) const {
  const MediumSpace space = whole_space();
  return {waves_, space,
          BasisOptions{Coordinates::informed, options_.solver.smooth_length * space.thickness_mm,
                       weight, damping, slope},
          blocks};
}

/// What the weight that ends has learned of the Hessian, for the next one.
void PiecePath::keep_pairs() {
  if (!stage_.function) return;
  OptimiserState& from = stage_.optimiser;
  state_.pairs.clear();
  for (std::size_t k = 0; k < from.steps.size(); ++k) {
    // One pair at a time is held twice.
    state_.pairs.push_back(stage_.function->to_fields(std::exchange(from.steps[k], {}),
                                                      std::exchange(from.changes[k], {})));
  }
  state_.pairs_weight = objective_->weight();
}

/// As in fit/minimise.cpp.
void PiecePath::begin_weight() {
  keep_pairs();
  save();
  stage_ = {};
  stage_.begun = state_.own;
  objective_->set_weight(state_.weight);
  if (!std::isfinite(objective_->value(stage_.begun))) {
    throw InputError("fit: the diffusion solver fails at the starting volume");
  }
  const AbsorptionScale by = scale();
  std::vector<CoefficientPair> rows =
      objective_->random_rows(options_.solver.metric_probes, options_.solver.seed);
  stage_.blocks = waves_->blocks(rows);
  for (CoefficientPair& row : rows) row = by.by_scaled(stage_.begun, std::move(row));
  stage_.scaled_blocks = waves_->blocks(rows);
  stage_.basis = std::make_unique<Basis>(basis_of(state_.weight, stage_.scaled_blocks,
                                                  mean_slope(pieces(), by, stage_.begun),
                                                  defaults::off_diagonal_damping));
  stage_.function = std::make_unique<PieceFunction>(*objective_, *stage_.basis, by, stage_.begun);
  stage_.optimiser.z = stage_.function->coordinates(stage_.begun);
  for (FieldPair& pair : std::exchange(state_.pairs, {})) {
    stage_.optimiser.steps.push_back(std::move(pair.step));
    stage_.optimiser.changes.push_back(std::move(pair.change));
  }
  restart(*stage_.function, stage_.optimiser, [&](Vector& step, Vector& change) {
    stage_.function->adopt(state_.pairs_weight, step, change);
  });
  stage_.corrected_chi2 = stage_.chi2 = objective_->chi2_per_value();
  record();
}

void PiecePath::update_correction() {
  stage_.optimiser.value = stage_.function->value(stage_.optimiser.z);
  stage_.optimiser.gradient = stage_.function->gradient();
  stage_.corrected_chi2 = stage_.chi2 = objective_->chi2_per_value();
  stage_.small_decreases = 0;
}

void PiecePath::repeat_weight() {
  update_correction();
  stage_.steps = 0;
  record();
}

bool PiecePath::correction_is_outdated() const {
  const double target = options_.path.target_chi2;
  return options_.path.correct_grid && state_.level == 0 && stage_.chi2 <= target &&
         stage_.corrected_chi2 > defaults::far_from_noise * target && objective_->shares_errors();
}

void PiecePath::minimise() {
  const double least = tolerance(options_.path, state_.last);
  const auto found = [&] { return stage_.small_decreases >= defaults::few_decreases; };
  const auto out_of_steps = [&] { return stage_.steps >= options_.path.stage_steps; };
  while (!found() && !out_of_steps()) {
    const double before = stage_.optimiser.value;
    if (step(*stage_.function, stage_.optimiser, options_.solver.optimiser) ==
        StepOutcome::stalled) {
      break;
    }
    ++stage_.steps;
    stage_.chi2 = objective_->chi2_per_value();
    const double after = stage_.optimiser.value;
    const bool small = before - after < std::max(least * after, shared_error_);
    stage_.small_decreases = small ? stage_.small_decreases + 1 : 0;
    record();
    if (correction_is_outdated()) {
      objective_->renew_correction(stage_.function->fields(stage_.optimiser.z));
      update_correction();
    }
  }
  stage_.ran_out = out_of_steps() && !found();
}

Minimum PiecePath::settle() {
  const auto round = [&] {
    minimise();
    state_.own = stage_.function->fields(stage_.optimiser.z);
    const double minimised = stage_.chi2;
    if (state_.last && correction_holds(stage_.corrected_chi2, minimised)) {
      objective_->value(state_.own);
      return Minimum{minimised, objective_->chi2_per_value()};
    }
    return Minimum{minimised, objective_->renew_correction(state_.own)};
  };
  const Minimum minimum = round();
  const bool may_go_on = !fixed_weight() || context_.continued.has_value();
  if (!may_go_on || !is_reverted(options_.path, minimum, state_.level == 0)) return minimum;
  repeat_weight();
  return round();
}

/// As in fit/minimise.cpp.
Outlook PiecePath::outlook(double chi2) const {
  const double values = objective_->used();
  const auto free_share = [&](const Basis& basis) {
    return 1.0 - pieces().sum(basis.determined(stage_.blocks)) / values;
  };
  const auto by_fields = [&](double weight) { return basis_of(weight, stage_.blocks, 1.0, 0.0); };
  Outlook outlook{free_share(by_fields(state_.weight))};
  outlook.tighter_end_gains =
      shared_error_ < options_.path.stage_tolerance * stage_.optimiser.value;
  outlook.excess = objective_->shared_errors().excess;
  const double next = state_.weight * options_.path.weight_factor;
  const Basis there = by_fields(next);
  const double gain = stage_.function->chi2_gain(there, next) / values;
  outlook.next_score =
      cross_validation(chi2 - gain, free_share(there)) / cross_validation(chi2, outlook.free_share);
  return outlook;
}

/// As in fit/fit.cpp.
void PiecePath::descend() {
  const PathOptions& path = options_.path;
  std::optional<Outlook> ahead;
  for (;;) {
    const Minimum minimum = settle();
    ahead = outlook(minimum.renewed);
    state_.end = end_of_path(path, state_.weight, minimum, ahead, state_.last_score);
    if (state_.end == PathEnd::model_error) break;
    state_.last_chi2 = minimum.renewed;
    state_.last_score = cross_validation(minimum.renewed, ahead->free_share);
    if (state_.end != PathEnd::unknown) break;
    state_.weight *= path.weight_factor;
    begin_weight();
  }
  const bool reverted = state_.end == PathEnd::model_error;
  if (reverted) {
    state_.own = stage_.begun;
    state_.weight /= path.weight_factor;
    objective_->renew_correction(state_.own);
  }
  state_.last = !context_.interim && needs_tighter_end(path, ahead);
  if (!state_.last) return;
  if (reverted) {
    begin_weight();
  } else {
    repeat_weight();
  }
}

void PiecePath::record() {
  state_.report.history.push_back({.level = state_.level,
                                   .weight = state_.weight,
                                   .step = stage_.steps,
                                   .solves = objective_->solves(),
                                   .objective = stage_.optimiser.value,
                                   .chi2_per_value = stage_.chi2,
                                   .roughness = objective_->roughness(),
                                   .seconds = seconds()});
  const int grids = static_cast<int>(levels_.size());
  progress_.update("fit", 0.0,
                   formatted("grid %d of %d, weight %.3g, chi2 %.4g, step %d", grids - state_.level,
                             grids, state_.weight, stage_.chi2, stage_.steps));
}

void PiecePath::save() {
  state_.seconds = seconds();
  state_.report.solves = objective_->solves();
  checkpoint_.save(state_);
}

PieceFit PiecePath::run() {
  if (std::optional<PathState> saved = checkpoint_.load()) {
    state_ = std::move(*saved);
    seconds_before_ = state_.seconds;
    state_.report.resumed = true;
    open(state_.level, state_.closer);
    objective_->renew_correction(state_.own);
  } else if (context_.continued) {
    begin_continued(*context_.continued);
  } else {
    begin();
  }
  begin_weight();
  while (state_.level > 0) {
    settle();
    begin_next_grid();
    begin_weight();
  }
  if (!state_.last) descend();
  if (state_.last) state_.last_chi2 = settle().renewed;
  if (fixed_weight())
    state_.end = context_.continued ? context_.continued->report.end : PathEnd::asked;
  FitReport& report = state_.report;
  report.chi2_per_value = state_.last_chi2;
  report.weight = state_.weight;
  report.end = state_.end;
  objective_->value(state_.own);
  report.shared = objective_->shared_errors();
  conclude_path(options_.path,
                {state_.last_chi2, report.shared.excess, state_.weight, state_.end, stage_.ran_out},
                report);
  report.backend = objective_->backend_name();
  report.data = static_cast<std::size_t>(objective_->used());
  report.solves = objective_->solves();
  report.seconds = seconds();
  return {objective_->fields(), state_.own, objective_->prediction(), std::move(report)};
}

}  // namespace

PieceFit fit_pieces(const PieceGrid& data, const FitOptions& options,
                    const PathCheckpoint& checkpoint, Progress& progress,
                    const PieceContext& context) {
  return PiecePath(data, options, checkpoint, progress, context).run();
}

PieceScore score_pieces(const PieceGrid& validation, const CoefficientPair& own,
                        const FitOptions& options) {
  PieceObjective objective(validation, piece_refinement(validation, nullptr),
                           options.solver.backend, options.data.term, {}, {});
  PieceScore score;
  score.chi2_per_value = objective.renew_correction(own);
  score.prediction = objective.prediction();
  return score;
}

}  // namespace kappamu::inverse::distributed
