#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
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
#include "app/mpi/npy_parts.h"
#include "app/mpi/path_files.h"
#include "app/mpi/piece_warnings.h"
#include "app/options/fit_options.h"
#include "core/appearance_error.h"
#include "core/error.h"
#include "core/numbers/coefficient_bounds.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/distributed/together.h"
#include "inverse/distributed/distributed_fit.h"
#include "io/atomic_file.h"
#include "io/measurements_file.h"
#include "pipeline/fit_files.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/channel_json.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/records/fit_record.h"
#include "pipeline/stages/validation_choice.h"
#include "pipeline/verify.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using namespace forward::distributed;
using inverse::distributed::PieceFit;
using inverse::distributed::PieceGrid;
using Json = nlohmann::ordered_json;

/// Of what `kappamu fit` can be asked for.
constexpr std::array<std::string_view, 14> taken{"convention",
                                                 "model_error_relative",
                                                 "model_error_of_maximum",
                                                 "regulariser",
                                                 "edge_slope",
                                                 "weight",
                                                 "target_chi2",
                                                 "stage_tolerance",
                                                 "final_tolerance",
                                                 "stage_steps",
                                                 "max_levels",
                                                 "correct_grid",
                                                 "hold_out",
                                                 "channels"};

struct FitArguments {
  std::string input, out;
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

/// Of one channel.
struct Validation {
  inverse::distributed::PieceScore score;
  std::vector<AppearanceError> error;  ///< of each pattern, all ranks together
};

/// Σ over all ranks by pattern, in exitance; the data's weights stand for their noise.
std::vector<AppearanceError> errors_of(const PieceGrid& data,
                                       const std::vector<double>& prediction) {
  const inverse::Problem& problem = data.problem;
  const std::size_t pixels = problem.seen_shape().cells();
  std::vector<double> sums(4 * static_cast<std::size_t>(problem.patterns), 0.0);
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    AppearanceError one;
    one.add(prediction[i], problem.data[i], 1.0 / problem.weight[i]);
    double* const sum = &sums[4 * (i / pixels)];
    sum[0] += one.misfit;
    sum[1] += one.signal;
    sum[2] += one.noise;
    sum[3] += 1.0;
  }
  data.pieces->sum(sums);
  std::vector<AppearanceError> errors;
  for (std::size_t k = 0; k < sums.size(); k += 4) {
    errors.push_back({sums[k], sums[k + 1], sums[k + 2], static_cast<std::size_t>(sums[k + 3])});
  }
  return errors;
}

class Fit {
 public:
  Fit(const FitArguments& arguments, bool steps);
  Json run();
  int exit_code() const { return exit_code_; }

 private:
  SurfaceMeasurements read_channel(std::size_t channel) const;
  void require_usable(const SurfaceMeasurements& piece) const;
  void choose_validation(const PieceGrid& all);
  PieceFit fit_all(const std::string& name, const PieceGrid& all);
  void fit(std::size_t channel);
  std::vector<double> with_validation(std::vector<double> prediction) const;
  Json record(double seconds, const std::vector<double>& memory) const;

  pipeline::FitStageOptions options_;
  fs::path input_, out_, folder_, partial_;
  std::unique_ptr<pipeline::OutputFolder> output_;  ///< of the first rank
  SurfaceMeasurements header_;                      ///< of the whole, without arrays
  bool masked_ = false;
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
  std::string found;
  on_first(comm, [&] {
    found = pipeline::find_measurements(input_).string();
    pipeline::require_as_written(found);
  });
  folder_ = shared(comm, found);
  together(comm, [&] {
    header_ = io::read_measurements_header(folder_);
    if (header_.two_faces()) {
      throw InputError((folder_ / "measurements.json").string() +
                       ": seen_faces lists two faces, and kappamu-mpi fits one; use kappamu fit");
    }
  });
  require_usual_voxel(header_.grid.voxel_mm, folder_.string());
  masked_ = fs::exists(folder_ / "mask.npy");
  const auto shape = npy_shape(comm, folder_ / "irradiance.npy");
  if (shape.size() != 3 || shape.front() == 0) {
    throw InputError((folder_ / "irradiance.npy").string() +
                     ": must be an array [patterns][v][u] of the lit face");
  }
  header_.patterns = static_cast<int>(shape.front());
  channels_ = pipeline::channels_of(header_, options_.channels);
  pieces_ = std::make_shared<BlockPieces>(
      comm, inverse::make_setup(header_, options_.fit.data.convention),
      options_.fit.path.max_levels - 1);
  on_first(comm, [&] {
    const std::string key = pipeline::Fingerprint()
                                .add(pipeline::options_json(options_))
                                .add(pipeline::measurements_fingerprint(folder_))
                                .add("kappamu-mpi")
                                .text();
    std::vector<std::string> outputs = pipeline::fit_outputs(out_);
    for (const char* name : {"volume.json", "coarse", pipeline::validated_folder}) {
      outputs.emplace_back(name);
    }
    output_ = std::make_unique<pipeline::OutputFolder>(
        out_, "fit", std::vector<fs::path>{folder_}, outputs, pipeline::Former::removed, key,
        options_.restart ? pipeline::Interrupted::removed : pipeline::Interrupted::continued);
  });
  partial_ = shared(comm, output_ ? output_->partial().string() : std::string());
  files_.emplace(header_, *pieces_, partial_, channels_.size());
}

/// One channel of the piece, as if that were the block.
SurfaceMeasurements Fit::read_channel(std::size_t channel) const {
  const auto read = [&](const char* name, Face face, bool by_channel) {
    Part part = face_part(header_.grid, face, header_.patterns, pieces_->held());
    if (by_channel) part = within(std::move(part), channel, header_.channels.size());
    const std::vector<double> values = read_part(comm, folder_ / name, part);
    return std::vector<float>(values.begin(), values.end());
  };
  SurfaceMeasurements piece = header_;
  piece.grid = pieces_->piece().shape;
  piece.channels = {header_.channels[channel]};
  piece.irradiance = read("irradiance.npy", header_.lit_face, false);
  piece.value = read("value.npy", header_.seen_face, true);
  piece.variance = read("variance.npy", header_.seen_face, true);
  if (masked_) {
    for (const float use : read("mask.npy", header_.seen_face, true)) {
      piece.mask.push_back(use != 0.0F ? 1 : 0);
    }
  }
  require_usable(piece);
  return piece;
}

/// As validate() of whole measurements, each rank its part.
void Fit::require_usable(const SurfaceMeasurements& piece) const {
  float brightest = 0.0F;
  together(comm, [&] {
    const auto fail = [&](const std::string& what) {
      throw InputError(folder_.string() + ": " + what);
    };
    for (const float e : piece.irradiance) {
      if (!std::isfinite(e) || e < 0.0F) fail("irradiance has a negative or non-finite value");
      brightest = std::max(brightest, e);
    }
    for (std::size_t i = 0; i < piece.value.size(); ++i) {
      if (!piece.mask.empty() && piece.mask[i] == 0) continue;
      if (!std::isfinite(piece.value[i])) {
        fail("value has a non-finite entry that mask does not exclude");
      }
      if (!std::isfinite(piece.variance[i]) || piece.variance[i] <= 0.0F) {
        fail("variance must be positive and finite wherever mask allows use");
      }
    }
  });
  brightest = static_cast<float>(largest(comm, brightest));
  if (brightest == 0.0F) {
    throw InputError(folder_.string() +
                     ": irradiance is zero everywhere; at least one pattern must light the sample");
  }
  require_usual_light(brightest, folder_.string());
}

/// By the light of the whole face, as the single machine does.
void Fit::choose_validation(const PieceGrid& all) {
  if (choice_) return;
  const inverse::Problem whole = inverse::distributed::whole_problem(all);
  SurfaceMeasurements light;
  light.grid = whole.setup.shape;
  light.lit_face = header_.lit_face;
  light.seen_face = header_.seen_face;
  light.patterns = header_.patterns;
  light.irradiance.assign(whole.irradiance.begin(), whole.irradiance.end());
  choice_ = pipeline::choose_validation(options_.hold_out, light,
                                        pipeline::ValidationMeasurements::absent);
  if (choice_->warning) warnings_.push_back(*choice_->warning);
  const std::vector<int>& out = choice_->patterns;
  for (int m = 0; m < header_.patterns; ++m) {
    if (std::find(out.begin(), out.end(), m) == out.end()) fitted_.push_back(m);
  }
}

/// fit_validated() of a volume: a fit without the validation patterns, its score, and one more
/// minimisation of all patterns at the weight found.
PieceFit Fit::fit_all(const std::string& name, const PieceGrid& all) {
  using namespace inverse::distributed;
  const auto fit_by = [&](const PieceGrid& data, const inverse::FitOptions& how,
                          const std::string& file, const PieceContext& context) {
    const PathFiles files(pieces_, partial_, file);
    return fit_pieces(data, how,
                      {[&](const auto& state) { files.save(state); }, [&] { return files.load(); }},
                      progress_, context);
  };
  if (choice_->patterns.empty()) return fit_by(all, options_.fit, name, {});
  PieceFit first = fit_by(select_patterns(all, fitted_), options_.fit, name, {{}, true});
  const PieceGrid apart = select_patterns(all, choice_->patterns);
  Validation validation{score_pieces(apart, first.own, options_.fit), {}};
  validation.error = errors_of(apart, validation.score.prediction);
  validation_.push_back(std::move(validation));
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
  const std::string name = header_.channels[channel];
  const PieceGrid all{pieces_, inverse::distributed::piece_problem(*pieces_, read_channel(channel),
                                                                   options_.fit.data.convention,
                                                                   options_.fit.data.model_error)};
  const double used = pieces_->sum(static_cast<double>(all.problem.used()));
  if (used == 0.0) throw InputError(folder_.string() + ": mask leaves nothing to fit");
  const double count = static_cast<double>(header_.seen_shape().cells()) * header_.patterns;
  used_ += used / count / static_cast<double>(channels_.size());
  choose_validation(all);
  PieceFit found = fit_all(name, all);
  files_->keep_prediction(with_validation(found.prediction));
  files_->keep(name, found);
  names_.push_back(name);
  for (const std::string& sentence :
       piece_warnings(*pieces_, found.fields.log_kappa, found.fields.log_mu, true)) {
    found.report.warnings.push_back(sentence);
  }
  reports_.push_back(std::move(found.report));
}

Json Fit::record(double seconds, const std::vector<double>& memory) const {
  pipeline::FitEvidence evidence;
  std::vector<inverse::FitStatus> statuses;
  Json channels = Json::array();
  std::vector<std::string> warnings = warnings_;
  for (std::size_t c = 0; c < names_.size(); ++c) {
    const inverse::FitReport& report = reports_[c];
    evidence.channels.push_back(
        {names_[c], report.status, report.chi2_per_value, 0.0, report.shared});
    statuses.push_back(report.status);
    Json channel = pipeline::channel_json(names_[c], report);
    if (!validation_.empty()) {
      AppearanceError all;
      for (const AppearanceError& error : validation_[c].error) all.add(error);
      channel["validation_E"] = all.E();
      channel["validation_noise_E"] = all.noise_E();
      channel["validation_chi2_per_value"] = validation_[c].score.chi2_per_value;
      channel["validation_values_used"] = all.count;
      evidence.validation.resize(validation_[c].error.size());
      for (std::size_t k = 0; k < evidence.validation.size(); ++k) {
        evidence.validation[k].add(validation_[c].error[k]);
      }
    }
    channels.push_back(std::move(channel));
    for (const std::string& w : report.warnings) warnings.push_back(names_[c] + ": " + w);
  }
  for (const int pattern : choice_->patterns) {
    evidence.validation_names.push_back(std::to_string(pattern));
  }
  evidence.used = used_;
  evidence.front_lit = header_.lit_face == header_.seen_face;
  evidence.warnings = warnings.size();
  pipeline::FitRecord record;
  record.status = pipeline::overall_status(statuses);
  record.grid = {header_.grid.nx, header_.grid.ny, header_.grid.nz};
  record.verdict = pipeline::make_verdict(evidence);
  Json fit{{"format", "kappamu-fit"}, {"version", 1}};
  pipeline::add_fit_record(record, fit);
  fit["voxel_mm"] = header_.grid.voxel_mm;
  fit["eta"] = header_.eta;
  fit["device"] = reports_.front().backend;
  fit["seconds"] = seconds;
  fit["memory_peak_bytes"] = *std::max_element(memory.begin(), memory.end());
  fit["memory_peak_bytes_by_rank"] = memory;
  fit["input"] = input_.string();
  fit["options"] = Json::parse(pipeline::options_json(options_));
  fit["validation"] = {{"source", to_string(choice_->source)}, {"patterns", choice_->patterns}};
  fit["channels"] = channels;
  fit["warnings"] = warnings;
  return fit;
}

Json Fit::run() {
  const Stopwatch watch;
  for (const int channel : channels_) fit(static_cast<std::size_t>(channel));
  const double mine = peak_memory();
  std::vector<double> memory(static_cast<std::size_t>(pieces_->ranks()));
  MPI_Allgather(&mine, 1, MPI_DOUBLE, memory.data(), 1, MPI_DOUBLE, comm);
  const Json fit = record(watch.seconds(), memory);
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
