#include "bench/forward_bench.h"

#include <sys/sysinfo.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/forward_record.h"
#include "bench/kernels.h"
#include "bench/measure.h"
#include "bench/peer_runner.h"
#include "bench/record.h"
#include "core/error.h"
#include "device/bandwidth.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;
using forward::Precision;

const std::vector<double> all_tolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
const std::vector<double> quickest_peer_tolerances{1e-2, 1e-4, 1e-6, 1e-8};
const std::vector<double> other_peer_tolerances{1e-2, 1e-4, 1e-6};
constexpr double voxel_mm = 0.25;

ProblemSpec headline(bool quick) {
  const GridShape shape =
      quick ? GridShape{32, 32, 10, voxel_mm} : GridShape{256, 256, 20, voxel_mm};
  return {"headline", shape, reference_inclusions(), 16, 16};
}

/// Writes what a section has so far, so that an interrupted one leaves a record all the same.
using Save = std::function<void(const Json& runs)>;

Json description_of(const ProblemSpec& spec) {
  return {{"name", spec.name},
          {"grid", {spec.shape.nx, spec.shape.ny, spec.shape.nz}},
          {"voxel_mm", spec.shape.voxel_mm},
          {"patterns", spec.patterns},
          {"judged_patterns", spec.judged},
          {"medium", to_string(spec.medium.kind)},
          {"contrast", spec.medium.contrast * spec.medium.background_contrast},
          {"background_contrast", spec.medium.background_contrast},
          {"mu", spec.medium.mu}};
}

Json description_of(const Problem& problem) {
  Json description = description_of(problem.spec());
  description["truth_error"] = problem.truth_error();
  return description;
}

void add(std::vector<Sample>& all, const std::vector<Sample>& some) {
  all.insert(all.end(), some.begin(), some.end());
}

/// Ours in both precisions.
std::vector<Sample> ours(const Problem& problem, const ForwardBenchOptions& options,
                         const std::vector<double>& single_tolerances = all_tolerances,
                         const std::vector<double>& double_tolerances = all_tolerances) {
  const int patterns = problem.spec().patterns;
  std::vector<Sample> samples =
      measure_grid_solver(problem, options.device, Precision::single_precision, patterns,
                          single_tolerances, options.repetitions);
  add(samples, measure_grid_solver(problem, options.device, Precision::double_precision, patterns,
                                   double_tolerances, options.repetitions));
  return samples;
}

/// The serial reference on one pattern, and the papers' methods while `seconds` last for each
/// solve.
std::vector<Sample> others(const Problem& problem, const ForwardBenchOptions& options,
                           double seconds, Progress& progress) {
  progress.update("bench", 0.0, problem.spec().name + ": serial reference");
  std::vector<Sample> samples = measure_grid_solver(
      problem, "reference", Precision::double_precision, 1, {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}, 1);
  if (options.device == "reference") return samples;
  for (const std::string& method : baseline_methods()) {
    progress.update("bench", 0.0, problem.spec().name + ": " + method);
    add(samples, measure_model(problem, method, options.device,
                               {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}, seconds));
  }
  return samples;
}

void measure_headline(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  const Problem problem(headline(options.quick), options.device);
  std::vector<Sample> samples = ours(problem, options);
  add(samples, others(problem, options, options.quick ? 0.5 : 6.0, progress));
  save(Json::array({{{"problem", description_of(problem)}, {"samples", to_json(samples)}}}));
}

void measure_kernels(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  const ProblemSpec spec = headline(options.quick);
  Json profiles = Json::array();
  for (const auto precision : {Precision::single_precision, Precision::double_precision}) {
    if (options.device == "reference") {
      progress.warn("section kernels needs an OpenCL device; nothing was measured");
      break;
    }
    profiles.push_back(
        to_json(profile_kernels(spec, options.device, precision, options.repetitions)));
  }
  save(Json::array({{{"problem", description_of(spec)}, {"profiles", profiles}}}));
}

/// The papers' smoothers alone, for as long as one may wait: how far they are from 1e-2 by then.
void measure_relaxation(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  const Problem problem(headline(options.quick), options.device);
  std::vector<Sample> samples =
      measure_grid_solver(problem, options.device, Precision::single_precision,
                          problem.spec().patterns, {1e-1, 1e-2, 1e-3, 1e-4}, options.repetitions);
  for (const char* method : {"gauss-seidel", "relaxation"}) {
    if (options.device == "reference") break;
    progress.update("bench", 0.0, method);
    add(samples,
        measure_model(problem, method, options.device, {1e-4}, options.quick ? 1.0 : 50.0));
  }
  save(Json::array({{{"problem", description_of(problem)}, {"samples", to_json(samples)}}}));
}

void measure_peers(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  const Problem problem(headline(options.quick), options.device);
  std::vector<Sample> samples =
      ours(problem, options, {1e-2, 1e-4, 1e-5, 1e-6, 1e-7}, {1e-5, 1e-6});
  Json trials = Json::object();
  const auto save_all = [&] {
    save(Json::array({{{"problem", description_of(problem)},
                       {"samples", to_json(samples)},
                       {"peers", trials}}}));
  };
  save_all();
  const int patterns = options.quick ? 2 : 3;
  for (const std::string& peer : options.peers ? available_peers() : std::vector<std::string>()) {
    progress.update("bench", 0.0, "peer " + peer);
    // The quickest peer deserves the finer curve.
    const bool quickest = peer == "hypre-pfmg";
    const PeerRun run = run_peer(problem, peer, quickest ? patterns : 1,
                                 quickest ? quickest_peer_tolerances : other_peer_tolerances,
                                 quickest ? options.repetitions : 1, options.folder / "exchange");
    add(samples, run.samples);
    trials[peer] = {{"ranks", run.ranks}, {"setting", run.setting}, {"tried", run.trials}};
    save_all();
  }
}

void measure_grids(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  std::vector<ProblemSpec> specs;
  const MediumSpec plain{.kind = MediumKind::smooth, .contrast = 10.0};
  const MediumSpec board{.kind = MediumKind::checkerboard, .contrast = 1e4};
  if (options.quick) {
    specs = {{"cube, inclusions", {16, 16, 16, voxel_mm}, reference_inclusions(), 4, 4}};
  } else {
    specs = {{"cube, smooth 10", {64, 64, 64, voxel_mm}, plain, 16, 16},
             {"cube, inclusions", {64, 64, 64, voxel_mm}, reference_inclusions(), 16, 16},
             {"cube, checkerboard 10^4", {64, 64, 64, voxel_mm}, board, 16, 16},
             {"odd slab, inclusions", {128, 128, 41, voxel_mm}, reference_inclusions(), 16, 16}};
  }
  Json runs = Json::array();
  for (const ProblemSpec& spec : specs) {
    progress.update("bench", 0.0, spec.name);
    const Problem problem(spec, options.device);
    std::vector<Sample> samples = ours(problem, options);
    add(samples, others(problem, options, options.quick ? 0.2 : 3.0, progress));
    runs.push_back({{"problem", description_of(problem)}, {"samples", to_json(samples)}});
    save(runs);
  }
}

/// A batch of 16 patterns in single precision takes about twelve arrays on the device and three in
/// double on the host, the truth for a few patterns besides.
bool fits(const GridShape& shape, int patterns, std::string& why) {
  struct sysinfo info {};
  if (sysinfo(&info) != 0) return true;
  const double free = static_cast<double>(info.freeram + info.bufferram) * info.mem_unit;
  const double need =
      static_cast<double>(shape.cells()) * patterns * (8.0 * sizeof(float) + 1.0 * sizeof(double));
  why = grid_name(shape) + " left out: it needs about " + std::to_string(std::lround(need / 1e9)) +
        " GB of memory, and " + std::to_string(std::lround(free / 1e9)) + " GB are free.";
  return need < free;
}

void measure_scaling(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  const std::vector<int> sizes = options.quick ? std::vector<int>{12, 16, 24}
                                               : std::vector<int>{32, 48, 64, 96, 128, 192, 256};
  Json runs = Json::array();
  for (const int n : sizes) {
    const int patterns = 16;
    const ProblemSpec spec{
        "cube", {n, n, n, voxel_mm}, reference_inclusions(), patterns, n > 128 ? 1 : 4};
    std::string why;
    if (!fits(spec.shape, patterns, why)) {
      progress.warn(why);
      continue;
    }
    progress.update("bench", 0.0, grid_name(spec.shape));
    const Problem problem(spec, options.device);
    std::vector<Sample> samples =
        measure_grid_solver(problem, options.device, Precision::single_precision, patterns, {1e-6},
                            n > 128 ? 1 : options.repetitions);
    if (options.peers && n <= 128) {
      for (const std::string& peer : available_peers()) {
        if (peer != "hypre-pfmg") continue;
        add(samples, run_peer(problem, peer, 1, {1e-6}, 1, options.folder / "exchange").samples);
      }
    }
    runs.push_back({{"problem", description_of(problem)}, {"samples", to_json(samples)}});
    save(runs);
  }
}

/// Iterations only: no truth is solved for.
void measure_iterations(const ForwardBenchOptions& options, Progress& progress, const Save& save) {
  const std::vector<int> sizes =
      options.quick ? std::vector<int>{12, 24} : std::vector<int>{32, 64, 128, 256};
  const std::vector<double> contrasts = options.quick
                                            ? std::vector<double>{10.0, 1e4}
                                            : std::vector<double>{1.0, 10.0, 1e2, 1e4, 1e6};
  Json rows = Json::array();
  for (const int n : sizes) {
    const GridShape shape{n, n, n, voxel_mm};
    forward::GridSetup setup;
    setup.shape = shape;
    const int patterns = n > 128 ? 1 : 4;
    const auto choice =
        forward::make_grid_solver(setup, options.device, Precision::single_precision);
    const auto b = choice.solver->make_field(patterns);
    const auto light = patch_light(shape, setup.lit_face, patterns);
    for (const MediumKind kind : {MediumKind::smooth, MediumKind::inclusions,
                                  MediumKind::checkerboard, MediumKind::layers}) {
      for (const double contrast : contrasts) {
        progress.update("bench", 0.0, grid_name(shape) + " " + to_string(kind));
        const Medium medium = make_medium(shape, {.kind = kind, .contrast = contrast});
        choice.solver->set_medium(medium.kappa.values(), medium.mu.values());
        choice.solver->light_source(light, *b);
        const auto phi = choice.solver->make_field(patterns);
        const forward::SolveReport report = choice.solver->solve(*b, *phi, {1e-6, 200});
        rows.push_back({{"grid", {n, n, n}},
                        {"medium", to_string(kind)},
                        {"contrast", contrast},
                        {"patterns", patterns},
                        {"precision", "single"},
                        {"tolerance", 1e-6},
                        {"iterations", report.iterations},
                        {"converged", report.termination == forward::Termination::converged},
                        {"seconds_per_rhs", report.seconds / patterns}});
      }
    }
    save(rows);
  }
}

struct Section {
  std::string name;
  void (*measure)(const ForwardBenchOptions&, Progress&, const Save&);
};
const std::vector<Section> sections{
    {"headline", measure_headline},     {"kernels", measure_kernels}, {"peers", measure_peers},
    {"relaxation", measure_relaxation}, {"grids", measure_grids},     {"scaling", measure_scaling},
    {"iterations", measure_iterations}};

}  // namespace

const std::vector<std::string>& forward_sections() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Section& section : sections) list.push_back(section.name);
    return list;
  }();
  return names;
}

void measure_forward(const std::string& name, const ForwardBenchOptions& options,
                     Progress& progress) {
  std::string known;
  for (const Section& section : sections) {
    if (section.name == name) {
      forward::GridSetup probe;
      probe.shape = {8, 8, 8, voxel_mm};
      const auto choice =
          forward::make_grid_solver(probe, options.device, Precision::single_precision);
      if (!choice.warning.empty()) progress.warn(choice.warning);
      Json record = record_header("forward-" + name, choice.solver->backend());
      const double load = record.at("machine").at("load").get<double>();
      if (load > 0.5 * record.at("machine").at("cores").get<double>()) {
        progress.warn(
            "the machine is busy (load " + std::to_string(std::lround(load)) +
            "): times and ratios of this record mean little; measure again when it rests");
      }
      // The host's is not that of a card.
      if (options.device != "reference") {
        record["machine"]["copy_bandwidth_bytes_per_second"] = device::measured_copy_bandwidth(
            device::Context::of(device::choose(device::list_devices(), options.device).index));
      }
      record["quick"] = options.quick;
      record["repetitions"] = options.repetitions;
      section.measure(options, progress, [&](const Json& runs) {
        record["runs"] = runs;
        write_record(record, options.folder / ("forward-" + name + ".json"));
      });
      return;
    }
    known += (known.empty() ? "" : ", ") + section.name;
  }
  throw InputError("--section '" + name + "' is unknown; choose one of " + known + ".");
}

}  // namespace kappamu::bench
