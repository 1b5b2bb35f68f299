#include "studies/forward/forward_bench.h"
#include "studies/forward/bandwidth.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "core/process_memory.h"
#include "forward/grid/opencl/solver_memory.h"
#include "studies/baseline/baseline_model.h"
#include "studies/forward/comparison.h"
#include "studies/forward/kernels.h"
#include "studies/forward/measure.h"
#include "studies/forward/peer_runner.h"
#include "studies/subjects.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using forward::Precision;

const std::vector<double> all_tolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
constexpr double voxel_mm = 0.25;

/// What every section needs.
class Bench {
 public:
  Bench(const Request& request, Progress& progress, Save save)
      : quick(request.size == Size::quick),
        peers(has_peer()),
        repetitions(request.count("repetitions", 3)),
        device(request.device),
        exchange(request.folder / "exchange"),
        progress_(progress),
        save_(std::move(save)) {
    forward::GridSetup probe;
    probe.shape = {8, 8, 8, voxel_mm};
    const auto choice = forward::make_grid_solver(probe, device, Precision::single_precision);
    if (!choice.warning.empty()) progress.warn(choice.warning);
    if (const double load = machine_load(); load > 0.5 * usable_cores()) {
      progress.warn("the machine is busy (load " + std::to_string(std::lround(load)) +
                    "): times and ratios of this record mean little; measure again when it rests");
    }
    // The host's is not that of a card.
    copy_bandwidth_ = device == "reference"
                          ? host_copy_bandwidth()
                          : measured_copy_bandwidth(device::Context::chosen(device));
    head_ = {{"device", choice.solver->backend()},
             {"machine", {{"copy_bandwidth_bytes_per_second", copy_bandwidth_}}},
             {"repetitions", repetitions}};
  }

  ProblemSpec headline() const {
    const GridShape shape =
        quick ? GridShape{32, 32, 10, voxel_mm} : GridShape{256, 256, 20, voxel_mm};
    return {"headline", shape, reference_inclusions(), 16, 16};
  }
  bool on_opencl() const { return device != "reference"; }
  void update(const std::string& what) const { progress_.update("bench", 0.0, what); }
  void warn(const std::string& sentence) const { progress_.warn(sentence); }
  void save(const char* key, const Json& values) const {
    Json body = head_;
    body[key] = values;
    save_(body);
  }
  Json run_of(const Problem& problem, const std::vector<Sample>& samples) const {
    Json run{{"problem", description_of(problem.spec())}, {"samples", to_json(samples)}};
    run["problem"]["truth_error"] = problem.truth_error();
    run["comparison"] = compare(samples, problem.setup().shape.cells(), copy_bandwidth_);
    return run;
  }
  static Json description_of(const ProblemSpec& spec) {
    return {{"name", spec.name},
            {"grid", {spec.shape.nx, spec.shape.ny, spec.shape.nz}},
            {"voxel_mm", spec.shape.voxel_mm},
            {"patterns", spec.patterns},
            {"compared_patterns", spec.compared},
            {"medium", to_string(spec.medium.kind)},
            {"contrast", spec.medium.contrast * spec.medium.background_contrast},
            {"background_contrast", spec.medium.background_contrast},
            {"mu", spec.medium.mu}};
  }

  /// Ours in both precisions.
  std::vector<Sample> ours(const Problem& problem,
                           const std::vector<double>& single_tolerances = all_tolerances,
                           const std::vector<double>& double_tolerances = all_tolerances) const;
  /// The serial reference on one pattern, and the papers' methods while `seconds` last for each
  /// solve, `relaxing` for their smoothers alone.
  std::vector<Sample> others(const Problem& problem, double seconds, double relaxing) const;

  const bool quick, peers;
  const int repetitions;
  const std::string device;
  const std::filesystem::path exchange;  ///< with the peers

 private:
  Progress& progress_;
  Save save_;
  double copy_bandwidth_ = 0.0;
  Json head_;
};

void add(std::vector<Sample>& all, const std::vector<Sample>& some) {
  all.insert(all.end(), some.begin(), some.end());
}

std::vector<Sample> Bench::ours(const Problem& problem,
                                const std::vector<double>& single_tolerances,
                                const std::vector<double>& double_tolerances) const {
  const int patterns = problem.spec().patterns;
  std::vector<Sample> samples = measure_grid_solver(problem, device, Precision::single_precision,
                                                    patterns, single_tolerances, repetitions);
  add(samples, measure_grid_solver(problem, device, Precision::double_precision, patterns,
                                   double_tolerances, repetitions));
  return samples;
}

std::vector<Sample> Bench::others(const Problem& problem, double seconds, double relaxing) const {
  update(problem.spec().name + ": serial reference");
  std::vector<Sample> samples = measure_grid_solver(
      problem, "reference", Precision::double_precision, 1, {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}, 1);
  if (!on_opencl()) return samples;
  for (const forward::MethodName& named : baseline::methods()) {
    const std::string& method = named.name;
    update(problem.spec().name + ": " + method);
    const bool smoother = method == "relaxation" || method == "gauss-seidel";
    add(samples, measure_model(problem, method, device, {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6},
                               smoother ? relaxing : seconds));
  }
  return samples;
}

/// The two smoothers alone may take a minute: how far they are from 1e-2 by then is a claim of
/// ours.
void measure_headline(const Request& request, Progress& progress, const Save& save) {
  const Bench bench(request, progress, save);
  const Problem problem(bench.headline(), bench.device);
  std::vector<Sample> samples = bench.ours(problem);
  add(samples, bench.others(problem, bench.quick ? 0.5 : 6.0, bench.quick ? 1.0 : 50.0));
  Json run = bench.run_of(problem, samples);
  run["relaxation"] = compare_relaxation(samples);
  bench.save("runs", Json::array({run}));
}

void measure_kernels(const Request& request, Progress& progress, const Save& save) {
  const Bench bench(request, progress, save);
  const ProblemSpec spec = bench.headline();
  Json profiles = Json::array();
  for (const auto precision : {Precision::single_precision, Precision::double_precision}) {
    if (!bench.on_opencl()) {
      bench.warn("section kernels needs an OpenCL device; nothing was measured");
      break;
    }
    profiles.push_back(to_json(profile_kernels(spec, bench.device, precision, bench.repetitions)));
  }
  bench.save("runs",
             Json::array({{{"problem", Bench::description_of(spec)}, {"profiles", profiles}}}));
}

void measure_peers(const Request& request, Progress& progress, const Save& save) {
  const Bench bench(request, progress, save);
  const Problem problem(bench.headline(), bench.device);
  std::vector<Sample> samples = bench.ours(problem, {1e-2, 1e-4, 1e-5, 1e-6, 1e-7}, {1e-5, 1e-6});
  Json run = bench.run_of(problem, samples);
  bench.save("runs", Json::array({run}));
  if (!bench.peers) return;
  bench.update(peer_name);
  const PeerRun peer = run_peer(problem, bench.quick ? 2 : 3, {1e-2, 1e-4, 1e-6, 1e-8},
                                bench.repetitions, bench.exchange);
  add(samples, peer.samples);
  run = bench.run_of(problem, samples);
  run["peers"][peer_name] = {
      {"ranks", peer.ranks}, {"setting", peer.setting}, {"tried", peer.trials}};
  bench.save("runs", Json::array({run}));
}

void measure_grids(const Request& request, Progress& progress, const Save& save) {
  const Bench bench(request, progress, save);
  const MediumSpec plain{.kind = MediumKind::smooth, .contrast = 10.0};
  const MediumSpec board{.kind = MediumKind::checkerboard, .contrast = 1e4};
  std::vector<ProblemSpec> specs{
      {"cube, smooth 10", {64, 64, 64, voxel_mm}, plain, 16, 16},
      {"cube, inclusions", {64, 64, 64, voxel_mm}, reference_inclusions(), 16, 16},
      {"cube, checkerboard 10^4", {64, 64, 64, voxel_mm}, board, 16, 16},
      {"odd slab, inclusions", {128, 128, 41, voxel_mm}, reference_inclusions(), 16, 16}};
  if (bench.quick) {
    specs = {{"cube, inclusions", {16, 16, 16, voxel_mm}, reference_inclusions(), 4, 4}};
  }
  Json runs = Json::array();
  for (const ProblemSpec& spec : specs) {
    bench.update(spec.name);
    const Problem problem(spec, bench.device);
    std::vector<Sample> samples = bench.ours(problem);
    const double seconds = bench.quick ? 0.2 : 3.0;
    add(samples, bench.others(problem, seconds, seconds));
    runs.push_back(bench.run_of(problem, samples));
    bench.save("runs", runs);
  }
}

/// Whether κ and μ on the host, the solver in single precision and, to compare, φ of all patterns
/// on the host and the truth in double find room.
bool fits(const ProblemSpec& spec, std::string& why) {
  forward::GridSetup setup;
  setup.shape = spec.shape;
  const auto solver = [&](int patterns, Precision precision) {
    return static_cast<double>(forward::solver_memory(setup, patterns, 2, patterns, precision));
  };
  const double of_pattern = sizeof(double) * static_cast<double>(spec.shape.cells());
  double need = solver(spec.patterns, Precision::single_precision) + 2.0 * of_pattern;
  if (spec.compared > 0) {
    need += solver(spec.compared, Precision::double_precision) +
            of_pattern * (spec.patterns + 2.0 * spec.compared);
  }
  return_freed_memory();  // of the cube before
  const double available = available_memory();
  why = grid_name(spec.shape) + " of " + std::to_string(spec.patterns) +
        " left out: it needs up to " + gigabytes(need) + " of memory, and " + gigabytes(available) +
        " are available.";
  return need < available;
}

void measure_scaling(const Request& request, Progress& progress, const Save& save) {
  const Bench bench(request, progress, save);
  struct Cube {
    int size, patterns;
  };
  // Sixteen patterns of larger cubes do not fit a small machine.
  const std::vector<Cube> cubes =
      bench.quick ? std::vector<Cube>{{12, 16}, {16, 16}, {24, 1}}
                  : std::vector<Cube>{{32, 16},  {48, 16},  {64, 16}, {96, 16}, {128, 16},
                                      {192, 16}, {256, 16}, {64, 1},  {128, 1}, {192, 1},
                                      {256, 1},  {384, 1},  {512, 1}};
  const int wanted = request.count("voxels", 0);
  Json runs = Json::array();
  for (const auto& [n, patterns] : cubes) {
    if (wanted > 0 && n != wanted) continue;
    // Beyond 256 voxels a side the solution in double does not fit a small machine either.
    const bool large = n > 128, truth = n <= 256;
    const ProblemSpec spec{"cube",
                           {n, n, n, voxel_mm},
                           reference_inclusions(),
                           patterns,
                           !truth  ? 0
                           : large ? 1
                                   : std::min(4, patterns)};
    std::string why;
    if (!fits(spec, why)) {
      bench.warn(why);
      continue;
    }
    bench.update(grid_name(spec.shape));
    const Problem problem(spec, bench.device);
    std::vector<Sample> samples = measure_grid_solver(
        problem, bench.device, Precision::single_precision, patterns, {1e-6}, bench.repetitions);
    if (bench.peers && !large && patterns > 1) {
      add(samples, run_peer(problem, 1, {1e-6}, 1, bench.exchange).samples);
    }
    runs.push_back(bench.run_of(problem, samples));
    bench.save("runs", runs);
  }
}

Json summary_of(const std::vector<Json>& /*records*/, const std::filesystem::path& folder) {
  return forward_summary(folder);
}

}  // namespace

Json forward_summary(const std::filesystem::path& folder) {
  const Subject subject = forward_subject();
  Json found = Json::object();
  Json summary = Json::object();
  for (const Section& section : subject.sections) {
    const auto file = record_file(folder, subject, section.name);
    if (std::filesystem::exists(file)) found[section.name] = read_record(file, subject.name);
  }
  if (found.empty()) {
    throw InputError(folder.string() +
                     " holds no record of a section; measure section peers or headline first.");
  }
  const char* first = found.contains("peers") ? "peers" : "headline";
  if (found.contains(first)) {
    const Json& run = found[first].at("runs").at(0);
    for (const char* name : {"grid", "patterns", "contrast", "background_contrast"}) {
      summary[name] = run.at("problem").at(name);
    }
    summary.update(run.at("comparison"));
  }
  summary["relaxation"] = found.contains("headline")
                              ? found["headline"]["runs"][0].value("relaxation", Json::array())
                              : Json::array();
  summary["kernels"] =
      found.contains("kernels") ? found["kernels"]["runs"][0].at("profiles") : Json::array();
  for (const auto& [name, record] : found.items()) summary["sections"].push_back(name);
  return summary;
}

Subject forward_subject() {
  return {
      "forward",
      "Time and true error of every method that solves the diffusion equation",
      R"(  kappamu-studies forward -o out/bench                    all sections, about half an hour
  kappamu-studies forward -o out/bench --section peers    one
  kappamu-studies forward -o out/bench --quick            toy grids, seconds

seconds_per_rhs: median over repetitions of the solve of all patterns from zero, divided by
their number, plus the set-up that a change of kappa and mu asks for, shared by the 16
patterns on every side. Peers' set-up leaves out the assembly of their matrix, and each
runs with the best of a few settings, named in the record. true_error: ||phi - phi*|| /
||phi*|| of the worst pattern, phi* converged in double to a residual of 1e-13; the papers'
methods show exitance only and are compared by the maps of all six faces. ratio: the peer's
time over ours at equal true error, interpolated between tolerances on logarithmic axes.

--json: of the folder's records: grid, patterns, contrast, method, precision, iterations,
seconds_per_rhs, true_error, bandwidth_fraction (bytes the whole solve must move over
seconds times measured copy bandwidth), peers with ratio, fastest_peer and its ratio,
relaxation (ratio at a true error of 1e-2, or a lower bound), kernels.

Do not trust it on a machine that does anything else.)",
      {{"headline", "every method on 256x256x20, 16 patterns, contrast 10, inclusions x100, /100",
        measure_headline},
       {"kernels", "seconds and bytes of each kernel of our solve there", measure_kernels},
       {"peers", "hypre's PFMG (scripts/setup.sh --peers) there, beside ours", measure_peers},
       {"grids", "every method on other grids and contrasts", measure_grids},
       {"scaling", "ours and hypre's PFMG on cubes of 32 to 512 voxels a side", measure_scaling}},
      {{"repetitions", "Median over these (default 3)", Setting::Kind::number, 1, 100},
       {"voxels", "Of scaling: cubes of so many voxels a side alone", Setting::Kind::number, 1,
        512}},
      summary_of};
}

}  // namespace kappamu::studies
