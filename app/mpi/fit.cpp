#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/mpi/commands.h"
#include "app/mpi/npy_parts.h"
#include "app/mpi/path_files.h"
#include "app/mpi/piece_warnings.h"
#include "core/error.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/distributed/together.h"
#include "inverse/distributed/distributed_fit.h"
#include "io/atomic_file.h"
#include "io/measurements_file.h"
#include "io/volume/volume_file.h"
#include "pipeline/fit_files.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/channel_json.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/records/fit_record.h"
#include "pipeline/verify.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using namespace forward::distributed;
using inverse::distributed::PieceFit;
using Json = nlohmann::ordered_json;

/// Voxels beyond which a coarser volume is left beside, for programs of one machine.
constexpr std::size_t most_for_one_machine = std::size_t{1} << 24;

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
  options.fit.regulariser.kind = inverse::RegulariserKind::h1;
  options.fit.path.model = inverse::Model::volume;
  options.fit.path.correct_grid = false;
  options.fit.path.max_levels = 1;
  options.fit.uncertainty.probes = 0;
  options.fit.solver.backend.precision = forward::Precision::double_precision;
  options.hold_out = "none";
  return options;
}

const MPI_Comm comm = MPI_COMM_WORLD;

class Fit {
 public:
  Fit(const FitArguments& arguments, bool steps);
  Json run();
  int exit_code() const { return exit_code_; }

 private:
  SurfaceMeasurements read_channel(std::size_t channel) const;
  void require_usable(const SurfaceMeasurements& piece) const;
  void fit(std::size_t channel);
  void keep(const std::string& channel, const PieceFit& found);
  void keep_coarse(const PieceFit& found);
  std::vector<float> own(const std::vector<double>& logs) const;
  io::VolumeSet described(const GridShape& shape) const;
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
  io::VolumeSet coarse_;  ///< on the first rank
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
  together(comm, [&] { header_ = io::read_measurements_header(folder_); });
  masked_ = fs::exists(folder_ / "mask.npy");
  const auto shape = npy_shape(comm, folder_ / "irradiance.npy");
  if (shape.size() != 3 || shape.front() == 0) {
    throw InputError((folder_ / "irradiance.npy").string() +
                     ": must be an array [patterns][v][u] of the lit face");
  }
  header_.patterns = static_cast<int>(shape.front());
  channels_ = pipeline::channels_of(header_, options_.channels);
  pieces_ = std::make_shared<BlockPieces>(
      comm, inverse::make_setup(header_, options_.fit.data.convention));
  if (!header_.smooth_error.none()) {
    warnings_.emplace_back(
        "Errors that pixels share (smooth_error) are taken for independent ones: the volumes may "
        "follow them");
  }
  on_first(comm, [&] {
    const std::string key = pipeline::Fingerprint()
                                .add(pipeline::options_json(options_))
                                .add(pipeline::measurements_fingerprint(folder_))
                                .add("kappamu-mpi")
                                .text();
    std::vector<std::string> outputs = pipeline::fit_outputs(out_);
    for (const char* name : {"volume.json", "coarse"}) outputs.emplace_back(name);
    output_ = std::make_unique<pipeline::OutputFolder>(
        out_, "fit", std::vector<fs::path>{folder_}, outputs, pipeline::Former::removed, key,
        options_.restart ? pipeline::Interrupted::removed : pipeline::Interrupted::continued);
  });
  partial_ = shared(comm, output_ ? output_->partial().string() : std::string());
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
  double light = 0.0;
  together(comm, [&] {
    const auto fail = [&](const std::string& what) {
      throw InputError(folder_.string() + ": " + what);
    };
    for (const float e : piece.irradiance) {
      if (!std::isfinite(e) || e < 0.0F) fail("irradiance has a negative or non-finite value");
      light += e;
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
  if (pieces_->sum(light) == 0.0) {
    throw InputError(folder_.string() +
                     ": irradiance is zero everywhere; at least one pattern must light the sample");
  }
}

void Fit::fit(std::size_t channel) {
  const std::string name = header_.channels[channel];
  const inverse::Problem problem = inverse::distributed::piece_problem(
      *pieces_, read_channel(channel), options_.fit.data.convention, options_.fit.data.model_error);
  const double used = pieces_->sum(static_cast<double>(problem.used()));
  if (used == 0.0) throw InputError(folder_.string() + ": mask leaves nothing to fit");
  const double all = static_cast<double>(header_.seen_shape().cells()) * header_.patterns;
  used_ += used / all / static_cast<double>(channels_.size());
  const PathFiles files(*pieces_, partial_, name);
  PieceFit found = inverse::distributed::fit_pieces(
      pieces_, problem, options_.fit,
      {[&](const auto& state) { files.save(state); }, [&] { return files.load(); }}, progress_);
  keep(name, found);
  for (const std::string& sentence :
       piece_warnings(*pieces_, found.fields.log_kappa, found.fields.log_mu, true)) {
    found.report.warnings.push_back(sentence);
  }
  reports_.push_back(std::move(found.report));
}

std::vector<float> Fit::own(const std::vector<double>& logs) const {
  std::vector<float> values(pieces_->owned().cells());
  pieces_->for_own(
      [&](std::size_t i, std::size_t k) { values[k] = static_cast<float>(std::exp(logs[i])); });
  return values;
}

void Fit::keep(const std::string& channel, const PieceFit& found) {
  const Part part = volume_part(header_.grid, pieces_->owned());
  write_part(comm, partial_ / ("kappa_" + channel + ".npy"), part,
             std::span<const float>(own(found.fields.log_kappa)));
  write_part(comm, partial_ / ("mu_" + channel + ".npy"), part,
             std::span<const float>(own(found.fields.log_mu)));
  const double per_value = inverse::exitance_per_value(header_, pieces_->whole());
  const FaceShape face = face_shape(pieces_->piece().shape, header_.seen_face);
  std::vector<float> prediction;
  for (std::size_t i = 0; i < found.prediction.size(); ++i) {
    const int k = static_cast<int>(i % face.cells());
    if (!pieces_->owns_pixel(header_.seen_face, k % face.nu, k / face.nu)) continue;
    prediction.push_back(static_cast<float>(found.prediction[i] / per_value));
  }
  write_part(
      comm, partial_ / "prediction.npy",
      within(face_part(header_.grid, header_.seen_face, header_.patterns, pieces_->owned(), true),
             names_.size(), channels_.size()),
      std::span<const float>(prediction));
  names_.push_back(channel);
  if (header_.grid.cells() > most_for_one_machine) keep_coarse(found);
}

/// Means over 2^n voxels along each axis, on the first rank.
void Fit::keep_coarse(const PieceFit& found) {
  int factor = 2;
  while (header_.grid.cells() / (static_cast<std::size_t>(factor) * factor * factor) >
         most_for_one_machine / 8) {
    factor *= 2;
  }
  const GridShape& whole = header_.grid;
  const auto coarse = [&](int n) { return (n + factor - 1) / factor; };
  const GridShape shape{coarse(whole.nx), coarse(whole.ny), coarse(whole.nz),
                        factor * whole.voxel_mm};
  std::vector<double> kappa(shape.cells(), 0.0), mu = kappa, count = kappa;
  const GridShape& piece = pieces_->piece().shape;
  const auto& first = pieces_->held().begin;
  pieces_->for_own([&](std::size_t i, std::size_t) {
    const auto nx = static_cast<std::size_t>(piece.nx), ny = static_cast<std::size_t>(piece.ny);
    const std::size_t to = shape.index((static_cast<int>(i % nx) + first[0]) / factor,
                                       (static_cast<int>(i / nx % ny) + first[1]) / factor,
                                       (static_cast<int>(i / nx / ny) + first[2]) / factor);
    kappa[to] += std::exp(found.fields.log_kappa[i]);
    mu[to] += std::exp(found.fields.log_mu[i]);
    count[to] += 1.0;
  });
  for (std::vector<double>* sums : {&kappa, &mu, &count}) pieces_->sum(*sums);
  for (std::size_t i = 0; i < count.size(); ++i) {
    kappa[i] /= count[i];
    mu[i] /= count[i];
  }
  coarse_.media.push_back({{shape, std::move(kappa)}, {shape, std::move(mu)}});
}

/// What volume.json says of the volumes, which are not here.
io::VolumeSet Fit::described(const GridShape& shape) const {
  io::VolumeSet set;
  set.channels = names_;
  for (std::size_t c = 0; c < names_.size(); ++c) {
    set.media.push_back({Volume<double>(shape, std::vector<double>()),
                         Volume<double>(shape, std::vector<double>())});
  }
  set.eta = header_.eta;
  set.metadata = {{"program", "kappamu-mpi fit"}, {"device", reports_.front().backend}};
  return set;
}

Json Fit::record(double seconds, const std::vector<double>& memory) const {
  pipeline::FitEvidence evidence;
  std::vector<inverse::FitStatus> statuses;
  Json channels = Json::array();
  std::vector<std::string> warnings = warnings_;
  for (std::size_t c = 0; c < names_.size(); ++c) {
    const inverse::FitReport& report = reports_[c];
    evidence.channels.push_back({names_[c], report.status, report.chi2_per_value});
    statuses.push_back(report.status);
    channels.push_back(pipeline::channel_json(names_[c], report));
    for (const std::string& w : report.warnings) warnings.push_back(names_[c] + ": " + w);
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
  fit["validation"] = {{"source", "none"}, {"patterns", Json::array()}};
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
  for (const std::string& name : names_) PathFiles(*pieces_, partial_, name).remove();
  on_first(comm, [&] {
    if (!coarse_.media.empty()) {
      io::VolumeSet words = described(coarse_.shape());
      words.media = std::move(coarse_.media);
      io::write_volume_folder(partial_ / "coarse", words);
    }
    io::write_text_atomically(partial_ / "volume.json", io::volume_json(described(header_.grid)));
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
read. The whole grid from the start, smoothing H1, every pattern fitted, no deviations
(docs/distributed.md). Killed and started again it goes on after the last weight that ended.)");
  auto options = std::make_shared<FitArguments>();
  auto steps = std::make_shared<bool>(false);
  pipeline::FitStageOptions& fit = options->options;
  command->add_option("input", options->input, "Folder of measurements, or run folder")->required();
  command->add_option("-o,--out", options->out, "Folder for the results; made if missing")
      ->required();
  command->add_option("--channel", fit.channels, "Fit this channel only; may be repeated");
  command->add_option("--lambda", fit.fit.path.weight, "Weight of the smoothing, fixed")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--final-tolerance", fit.fit.path.final_tolerance,
                   "Relative decrease per step below which a minimum is found (default 3e-4)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--steps", fit.fit.path.stage_steps, "Steps allowed at a weight (default 400)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--solver-tolerance", fit.fit.solver.backend.solve.tolerance,
                   "Relative residual of a solve (default 1e-4)")
      ->check(CLI::Range(1e-14, 0.1));
  command->add_flag("--restart", fit.restart, "Ignore the checkpoints in OUT");
  command->add_flag("--verbose", *steps, "A line for each step");
  command->callback([options, steps, &globals] { run_fit(*options, globals, *steps); });
}

}  // namespace kappamu::app::mpi
