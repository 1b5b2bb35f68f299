#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/mpi/commands.h"
#include "app/mpi/fit_folder.h"
#include "app/mpi/measurement_parts.h"
#include "app/mpi/path_files.h"
#include "app/mpi/piece_record.h"
#include "app/mpi/piece_warnings.h"
#include "app/options/fit_options.h"
#include "core/error.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/distributed/together.h"
#include "inverse/distributed/distributed_fit.h"
#include "io/atomic_file.h"
#include "pipeline/fit_files.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/records/fit_record.h"
#include "pipeline/stages/validation_choice.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using namespace forward::distributed;
using inverse::distributed::PieceFit;
using inverse::distributed::PieceGrid;
using Json = nlohmann::ordered_json;

/// Of what `kappamu fit` can be asked for.
constexpr std::array<std::string_view, 28> taken{"loss",
                                                 "huber_threshold",
                                                 "student_freedom",
                                                 "convention",
                                                 "model_error_relative",
                                                 "model_error_of_maximum",
                                                 "coarse_model_error_relative",
                                                 "coarse_model_error_of_maximum",
                                                 "regulariser",
                                                 "edge_slope",
                                                 "anchor_length",
                                                 "start_kappa",
                                                 "start_mu",
                                                 "weight",
                                                 "first_weight",
                                                 "last_weight",
                                                 "weight_factor",
                                                 "target_chi2",
                                                 "stage_tolerance",
                                                 "final_tolerance",
                                                 "stage_steps",
                                                 "max_levels",
                                                 "correct_grid",
                                                 "loose_solves",
                                                 "metric_probes",
                                                 "seed",
                                                 "hold_out",
                                                 "channels"};

struct FitArguments {
  std::string input, out, validate;
  pipeline::FitStageOptions options = pipeline::usual_options();
};

/// On the first rank's standard error, where that is asked for.
class Steps final : public Progress {
 public:
  Steps(bool told, bool steps) : told_(told), steps_(steps) {}
  void update(const std::string& stage, double, const std::string& detail) override {
    if (told_ && steps_) std::fprintf(stderr, "%s: %s\n", stage.c_str(), detail.c_str());
  }
  void warn(const std::string& sentence) override {
    if (told_) std::fprintf(stderr, "kappamu-mpi: %s\n", shown_text(sentence).c_str());
  }

 private:
  bool told_, steps_;
};

/// What kappamu-mpi does not do is recorded as switched off.
pipeline::FitStageOptions done_here(pipeline::FitStageOptions options) {
  if (options.fit.regulariser.kind == inverse::RegulariserKind::wang2008) {
    throw InputError("the regulariser wang2008 is that of one machine; take huber-tv or h1");
  }
  options.fit.path.model = inverse::Model::volume;
  options.fit.data.physics = inverse::Physics::diffusion;
  options.fit.solver.coordinates = inverse::Coordinates::informed;
  options.fit.solver.optimiser.method = inverse::Method::lbfgs;
  options.fit.uncertainty.probes = options.fit.uncertainty.sensitivity_probes = 0;
  options.fit.solver.backend.precision = forward::Precision::double_precision;
  return options;
}

const MPI_Comm comm = MPI_COMM_WORLD;

class Fit {
 public:
  Fit(const FitArguments& arguments, bool steps);
  Json run();
  int exit_code() const { return exit_code_; }

 private:
  void read();
  void open_folder();
  PieceGrid grid_of(const MeasurementParts& parts, std::size_t channel) const;
  void choose_validation(const PieceGrid& all);
  void score(const PieceGrid& apart, const PieceFit& found);
  PieceFit fit_all(const std::string& name, const PieceGrid& all, std::size_t channel);
  void fit(std::size_t channel);
  std::vector<double> with_validation(std::vector<double> prediction) const;
  const SurfaceMeasurements& header() const { return measured_->header(); }

  pipeline::FitStageOptions options_;
  fs::path input_, out_, partial_;
  std::unique_ptr<pipeline::OutputFolder> output_;  ///< of the first rank
  std::optional<MeasurementParts> measured_;
  std::optional<MeasurementParts> apart_;  ///< that validate the fit
  std::shared_ptr<const BlockPieces> pieces_;
  std::vector<int> channels_;
  Steps progress_;
  std::vector<std::string> names_;
  std::vector<inverse::FitReport> reports_;
  double used_ = 0.0;
  std::vector<std::string> warnings_;
  std::optional<FitFolder> files_;
  std::optional<pipeline::ValidationChoice> choice_;
  std::vector<int> fitted_;             ///< patterns that the validated fit sees
  std::vector<Validation> validation_;  ///< by channel; empty without any
  int exit_code_ = 0;
};

Fit::Fit(const FitArguments& arguments, bool steps)
    : options_(done_here(pipeline::resolve(arguments.options))),
      input_(fs::absolute(arguments.input).lexically_normal()),
      out_(arguments.out),
      progress_(
          [] {
            int rank = 0;
            MPI_Comm_rank(comm, &rank);
            return rank == 0;
          }(),
          steps) {
  if (!arguments.validate.empty()) options_.validate = fs::absolute(arguments.validate);
  read();
  open_folder();
}

void Fit::read() {
  std::string found, validation;
  on_first(comm, [&] {
    found = pipeline::find_measurements(input_).string();
    validation = pipeline::find_validation(input_, options_).value_or(fs::path()).string();
  });
  measured_.emplace(shared(comm, found));
  channels_ = pipeline::channels_of(header(), options_.channels);
  const auto setup_of = [&](const SurfaceMeasurements& header) {
    return inverse::make_setup(header, options_.fit.data.convention);
  };
  pieces_ =
      std::make_shared<BlockPieces>(comm, setup_of(header()), options_.fit.path.max_levels - 1);
  validation = shared(comm, validation);
  if (validation.empty()) return;
  apart_.emplace(validation);
  pipeline::require_same_sample(header(), apart_->header(), validation);
  const forward::GridSetup apart = setup_of(apart_->header()), &fitted = pieces_->whole();
  if (apart.lit_face != fitted.lit_face || apart.source != fitted.source ||
      apart.sides != fitted.sides) {
    throw InputError(validation +
                     ": its light differs from that of the measurements to fit (lit_face, light or "
                     "sides), which kappamu-mpi does not take; use kappamu fit");
  }
}

void Fit::open_folder() {
  on_first(comm, [&] {
    pipeline::Fingerprint key;
    key.add(pipeline::options_json(options_));
    key.add(pipeline::measurements_fingerprint(measured_->folder()));
    if (apart_) key.add(pipeline::measurements_fingerprint(apart_->folder()));
    std::vector<std::string> outputs = pipeline::fit_outputs(out_);
    for (const char* name : {"volume.json", "coarse", pipeline::validated_folder}) {
      outputs.emplace_back(name);
    }
    std::vector<fs::path> inputs{measured_->folder()};
    if (apart_) inputs.push_back(apart_->folder());
    output_ = std::make_unique<pipeline::OutputFolder>(
        out_, "fit", inputs, outputs, pipeline::Former::removed, key.add("kappamu-mpi").text(),
        options_.restart ? pipeline::Interrupted::removed : pipeline::Interrupted::continued);
  });
  partial_ = shared(comm, output_ ? output_->partial().string() : std::string());
  files_.emplace(header(), *pieces_, partial_, channels_.size());
}

/// By the light of the whole face, as the single machine does.
void Fit::choose_validation(const PieceGrid& all) {
  if (choice_) return;
  const inverse::Problem whole = inverse::distributed::whole_problem(all);
  SurfaceMeasurements light;
  light.grid = whole.setup.shape;
  light.lit_face = header().lit_face;
  light.seen_face = header().seen_face;
  light.patterns = header().patterns;
  light.irradiance.assign(whole.irradiance.begin(), whole.irradiance.end());
  choice_ = pipeline::choose_validation(options_.hold_out, light,
                                        apart_ ? pipeline::ValidationMeasurements::present
                                               : pipeline::ValidationMeasurements::absent);
  if (choice_->warning) warnings_.push_back(*choice_->warning);
  const std::vector<int>& out = choice_->patterns;
  for (int m = 0; m < header().patterns; ++m) {
    if (std::find(out.begin(), out.end(), m) == out.end()) fitted_.push_back(m);
  }
}

PieceGrid Fit::grid_of(const MeasurementParts& parts, std::size_t channel) const {
  const inverse::DataOptions& data = options_.fit.data;
  return {pieces_, inverse::distributed::piece_problem(*pieces_, parts.channel(*pieces_, channel),
                                                       data.convention, data.model_error)};
}

/// How the volume predicts patterns that it has not seen.
void Fit::score(const PieceGrid& apart, const PieceFit& found) {
  Validation validation{inverse::distributed::score_pieces(apart, found.own, options_.fit), {}};
  validation.error = errors_of(apart, validation.score.prediction);
  validation_.push_back(std::move(validation));
}

/// fit_validated() of a volume: a fit without the validation patterns, its score, and one more
/// minimisation of all patterns at the weight found.
PieceFit Fit::fit_all(const std::string& name, const PieceGrid& all, std::size_t channel) {
  using namespace inverse::distributed;
  const auto fit_by = [&](const PieceGrid& data, const inverse::FitOptions& how,
                          const std::string& file, const PieceContext& context) {
    const PathFiles files(pieces_, partial_, file);
    return fit_pieces(data, how,
                      {[&](const auto& state) { files.save(state); }, [&] { return files.load(); }},
                      progress_, context);
  };
  if (choice_->patterns.empty()) {
    PieceFit found = fit_by(all, options_.fit, name, {});
    if (!apart_) return found;
    score(grid_of(*apart_, channel), found);
    files_->keep_prediction("prediction_validate.npy", apart_->header(),
                            validation_.back().score.prediction);
    return found;
  }
  PieceFit first = fit_by(select_patterns(all, fitted_), options_.fit, name, {{}, true});
  score(select_patterns(all, choice_->patterns), first);
  files_->keep_validated(name, first.own);
  inverse::FitOptions again = options_.fit;
  again.path.weight = first.report.weight;
  return fit_by(all, again, "all_" + name, {PieceContinuation{first.own, first.report}, false});
}

/// Validation patterns as the volume predicts them that did not see them.
std::vector<double> Fit::with_validation(std::vector<double> prediction) const {
  if (choice_->patterns.empty()) return prediction;
  const std::vector<double>& apart = validation_.back().score.prediction;
  const std::size_t pixels = apart.size() / choice_->patterns.size();
  for (std::size_t k = 0; k < choice_->patterns.size(); ++k) {
    std::copy_n(apart.begin() + static_cast<std::ptrdiff_t>(k * pixels), pixels,
                prediction.begin() + static_cast<std::ptrdiff_t>(
                                         static_cast<std::size_t>(choice_->patterns[k]) * pixels));
  }
  return prediction;
}

void Fit::fit(std::size_t channel) {
  const std::string name = header().channels[channel];
  const PieceGrid all = grid_of(*measured_, channel);
  const double used = pieces_->sum(static_cast<double>(all.problem.used()));
  if (used == 0.0) throw InputError(measured_->folder().string() + ": mask leaves nothing to fit");
  const double count = static_cast<double>(header().seen_shape().cells()) * header().patterns;
  used_ += used / count / static_cast<double>(channels_.size());
  choose_validation(all);
  PieceFit found = fit_all(name, all, channel);
  files_->keep_prediction("prediction.npy", header(), with_validation(found.prediction));
  files_->keep(name, found);
  names_.push_back(name);
  for (const std::string& sentence :
       piece_warnings(*pieces_, found.fields.log_kappa, found.fields.log_mu, true)) {
    found.report.warnings.push_back(sentence);
  }
  reports_.push_back(std::move(found.report));
}

Json Fit::run() {
  const Stopwatch watch;
  for (const int channel : channels_) fit(static_cast<std::size_t>(channel));
  const double mine = peak_memory();
  std::vector<double> memory(static_cast<std::size_t>(pieces_->ranks()));
  MPI_Allgather(&mine, 1, MPI_DOUBLE, memory.data(), 1, MPI_DOUBLE, comm);
  const Json fit = to_json({header(), *choice_, options_, input_, names_, reports_, validation_,
                            warnings_, used_, watch.seconds(), memory});
  for (const std::string& name : names_) {
    for (const std::string& file : {name, "all_" + name}) {
      PathFiles(pieces_, partial_, file).remove();
    }
  }
  files_->write_words(reports_.front().backend);
  on_first(comm, [&] {
    io::write_text_atomically(partial_ / "fit.json", fit.dump(1) + "\n");
    output_->commit();
  });
  exit_code_ = pipeline::verdict_from_json(fit.at("verdict")).exit_code();
  for (const Json& warning : fit.at("warnings")) progress_.warn(warning.get<std::string>());
  return fit;
}

void run_fit(const FitArguments& arguments, Globals& globals, bool steps) {
  Fit fit(arguments, steps);
  const Json result = fit.run();
  globals.exit_code = fit.exit_code();
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) return;
  if (globals.json) {
    std::printf("%s\n", result.dump().c_str());
    return;
  }
  for (const Json& channel : result.at("channels")) {
    std::printf("%-5s chi2 per value %-8.3g %6.1f s  %s: %s\n",
                channel.at("name").get<std::string>().c_str(),
                channel.at("chi2_per_value").get<double>(), channel.at("seconds").get<double>(),
                channel.at("status").get<std::string>().c_str(),
                channel.at("reason").get<std::string>().c_str());
  }
  std::printf("%s  (at most %s a rank)\n", (fs::path(arguments.out) / "volume.json").c_str(),
              gigabytes(result.at("memory_peak_bytes").get<double>()).c_str());
}

}  // namespace

void add_fit(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "fit",
      R"(Find the volumes of kappa and mu that explain surface measurements, cut between the ranks.

Reads what `kappamu fit` reads and leaves a folder that `kappamu report`, `export` and `view`
read. Volumes alone, by diffusion, without deviations; all else is that fit (docs/distributed.md).
Killed and started again it goes on at the weight that it had come to.)");
  auto options = std::make_shared<FitArguments>();
  auto steps = std::make_shared<bool>(false);
  pipeline::FitStageOptions& fit = options->options;
  command->add_option("input", options->input, "Folder of measurements, or run folder")->required();
  command->add_option("-o,--out", options->out, "Folder for the results; made if missing")
      ->required();
  command
      ->add_option("--validate", options->validate,
                   "Measurements of validation patterns to predict and score (default: "
                   "INPUT/measurements_validate)")
      ->type_name("FOLDER");
  add_fit_options(*command, fit, taken);
  command
      ->add_option("--solver-tolerance", fit.fit.solver.backend.solve.tolerance,
                   "Least relative residual that a solve is asked for (default 1e-4)")
      ->check(CLI::Range(1e-14, 0.1));
  command->add_flag("--restart", fit.restart, "Ignore the checkpoints in OUT");
  command->add_flag("--verbose", *steps, "A line for each step");
  command->callback([options, steps, &globals] { run_fit(*options, globals, *steps); });
}

}  // namespace kappamu::app::mpi
