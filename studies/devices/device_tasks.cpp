#include "studies/devices/device_tasks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/mesh/shapes.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "device/traffic.h"
#include "forward/montecarlo/photon_tracer.h"
#include "inverse/problem/predict.h"
#include "render/embree_caster.h"
#include "studies/dipole/dipole_bench.h"
#include "studies/forward/comparison.h"
#include "studies/forward/measure.h"
#include "studies/inverse/inverse_fit.h"
#include "studies/objects/even_cubes.h"
#include "studies/polygrid/live_frames.h"
#include "tests/cases/media.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

/// Each measurement with a device: a middle one of these.
int repetitions(const Request& request) {
  return request.count("repetitions", request.size == Size::quick ? 2 : 5);
}

double median_seconds(int count, const std::function<void()>& work) {
  std::vector<double> seconds;
  for (int k = 0; k < count; ++k) {
    const Stopwatch watch;
    work();
    seconds.push_back(watch.seconds());
  }
  return median(seconds);
}

device::Context& context_of(const Place& place) {
  return device::Context::chosen(place.wanted());
}

/// Kernels that `work` starts; none without OpenCL.
std::optional<std::size_t> launches_in(const Place& place, const std::function<void()>& work) {
  if (!place.device) return std::nullopt;
  return context_of(place).launches_of(work).size();
}

// ---- Blocks

constexpr double block_tolerance = 1e-6;
constexpr int block_patterns = 16;

/// The host's solver is the serial reference, of which one pattern stands for all.
DeviceTask block_task(const Request& request, const std::string& name, const GridShape& shape,
                      double goal_seconds) {
  const int count = repetitions(request);
  const auto measure = [=](const Place& place) -> std::optional<DeviceAnswer> {
    const int patterns = place.device ? block_patterns : 1;
    const Problem problem({name, shape, reference_inclusions(), block_patterns, 0}, place.wanted());
    DeviceAnswer answer;
    const Sample sample =
        measure_grid_solver(problem, place.wanted(), forward::Precision::single_precision, patterns,
                            {block_tolerance}, place.device ? count : 1, &answer.values)[0];
    answer.values.resize(shape.cells());  // of the first pattern
    answer.seconds = sample.solve_seconds_per_rhs * block_patterns;
    answer.set_up_seconds = sample.set_up_seconds;
    answer.count = block_patterns;
    answer.size = grid_name(shape) + ", " + std::to_string(block_patterns) + " right-hand sides";
    if (!place.device) answer.note = "serial, double precision; one right-hand side times 16";
    answer.allowed = 2.0 * block_tolerance;
    return answer;
  };
  return {name,
          "right-hand sides",
          "≤ " + std::to_string(std::lround(1e3 * goal_seconds)) + " ms",
          "twice the residual that each is solved to",
          [=](const DeviceAnswer& answer) { return answer.seconds <= goal_seconds; },
          measure};
}

DeviceTask slab(const Request& request) {
  const GridShape shape = request.size == Size::quick   ? GridShape{32, 32, 10, 0.25}
                          : request.size == Size::small ? GridShape{128, 128, 20, 0.25}
                                                        : GridShape{256, 256, 20, 0.25};
  return block_task(request, "solve", shape, 8e-3);
}

DeviceTask cube(const Request& request) {
  const int n = request.size == Size::quick ? 24 : request.size == Size::small ? 96 : 256;
  return block_task(request, "solve, cube", {n, n, n, 0.25}, 80e-3);
}

std::string shown(const device::Traffic& passed, const Stopwatch& watch, int repeated) {
  const auto each = [&](auto sum) { return static_cast<double>(sum) / repeated; };
  return formatted("the host's own %.2f s, %.0f waits, %.0f launches, %.0f MB between them",
                   each(watch.seconds() - passed.seconds), each(passed.waits),
                   each(passed.launches), 1e-6 * each(passed.bytes));
}

/// Its vectors where `vectors` says. On the host alone a fit takes hours.
DeviceTask fit_by(const Request& request, const std::string& name, inverse::VectorPlace vectors) {
  const int side = request.count("side", request.size == Size::full ? 64 : 12);
  const int depth = side > 64 ? 20 : side > 12 ? 12 : 6;
  const Block block{.grid = {side, side, depth, 0.5},
                    .precision = forward::Precision::single_precision};
  const auto truth = make_truth(block.grid.refined(2), {.seed = request.seed});
  auto measured = std::make_shared<SurfaceMeasurements>(
      expose(block, truth, bar_light(block.grid, block.lit, 8)));
  add_noise(*measured, block.noise, request.seed);
  auto unseen = std::make_shared<SurfaceMeasurements>(expose_patches(block, truth, 8));
  const int count = std::min(3, repetitions(request));
  const auto measure = [=](const Place& place) -> std::optional<DeviceAnswer> {
    if (!place.device && request.size != Size::quick) return std::nullopt;
    inverse::FitOptions options;
    options.solver.backend.device = place.wanted();
    options.solver.backend.vectors = vectors;
    Progress silent;
    inverse::ChannelFit found;
    const auto work = [&] { found = inverse::fit_channel(*measured, 0, options, {}, silent); };
    if (place.device) work();  // compiles
    DeviceAnswer answer;
    const device::Traffic before = device::traffic();
    const Stopwatch watch;
    const int repeated = place.device ? count : 1;
    answer.seconds = median_seconds(repeated, work);
    if (place.device) answer.note = shown(device::traffic().since(before), watch, repeated);
    answer.count = found.report.solves.total();
    const std::vector<float> images = inverse::predict(found.medium, *unseen, {});
    answer.values.assign(images.begin(), images.end());
    answer.size = grid_name(block.grid) + ", 16 patterns, 1 % noise, one channel";
    // Two fits to independent noise would differ by √2 of their distance from the truth.
    answer.allowed = std::sqrt(2.0 * appearance_error(found.medium, *unseen));
    return answer;
  };
  return {name,    "solves of all patterns",
          "",      "√2 of the images' distance from the truth's, under light that no fit saw",
          nullptr, measure};
}

DeviceTask fit(const Request& request) {
  return fit_by(request, "fit", inverse::VectorPlace::automatic);
}
DeviceTask fit_host(const Request& request) {
  return fit_by(request, "fit, vectors on the host", inverse::VectorPlace::host);
}
DeviceTask fit_device(const Request& request) {
  return fit_by(request, "fit, vectors on the device", inverse::VectorPlace::device);
}

// ---- Objects

constexpr double cubes_tolerance = 1e-3;

/// A torus of marble (red, Jensen et al. 2001), 72 mean free paths, under an even sky.
struct TorusOfCubes {
  static constexpr Coefficients marble{0.152, 0.0021};
  static constexpr double size_mm = 72.0 * 3.0 * marble.kappa, eta = 1.5;

  TriangleMesh mesh;
  Surface surface;
  std::unique_ptr<render::MovableCaster> rays;
  ObjectMedium medium;
  std::vector<forward::ObjectLight> sky;
  EvenCubes cubes;

  TorusOfCubes(int tessellation, int level)
      : mesh(make_shape("torus", size_mm, tessellation)),
        surface(surface_of(mesh)),
        rays(render::make_embree_caster(mesh)),
        medium(marble),
        sky{{{}, std::vector<double>(surface.size(), 1.0)}},
        cubes({mesh, surface, *rays, medium, eta, sky}, level, false) {}
};

/// How long the linear systems take; a new solver assembles its equations in the first ones.
class TimedSolver final : public forward::linear::LinearSolver {
 public:
  explicit TimedSolver(std::unique_ptr<LinearSolver> solver) : solver_(std::move(solver)) {}
  forward::linear::CgReport solve(const std::vector<forward::linear::Load>& b,
                                  std::vector<std::vector<double>>& x,
                                  const forward::linear::CgEnd& ends, std::size_t level) override {
    const Stopwatch watch;
    forward::linear::CgReport report = solver_->solve(b, x, ends, level);
    seconds_ += watch.seconds();
    return report;
  }
  /// Of all since the last call.
  double take_seconds() { return std::exchange(seconds_, 0.0); }

 private:
  std::unique_ptr<LinearSolver> solver_;
  double seconds_ = 0.0;
};

DeviceTask embedded_cubes(const Request& request) {
  const int level = request.size == Size::quick ? 4 : request.size == Size::small ? 6 : 8;
  const auto own =
      std::make_shared<const TorusOfCubes>(request.size == Size::quick ? 24 : 192, level);
  const int count = repetitions(request);
  const auto measure = [=](const Place& place) -> std::optional<DeviceAnswer> {
    DeviceAnswer answer;
    forward::embedded::Answers found;
    std::vector<double> systems, assembly, whole;
    for (int k = 0; k <= count; ++k) {
      TimedSolver solver(own->cubes.solver(place.wanted()));
      found = own->cubes.answers(solver, cubes_tolerance);
      const double first = solver.take_seconds();
      const Stopwatch watch;
      found = own->cubes.answers(solver, cubes_tolerance);
      if (k == 0) continue;  // compiled
      whole.push_back(watch.seconds());
      systems.push_back(solver.take_seconds());
      if (k == count) {
        answer.launches = launches_in(place, [&] { own->cubes.answers(solver, cubes_tolerance); });
      }
      assembly.push_back(std::max(0.0, first - systems.back()));
    }
    answer.seconds = median(systems);
    answer.set_up_seconds = median(assembly);
    answer.note = "linear systems on two levels; with loads and exitance " +
                  shown_number(median(whole), "%.3g") + " s";
    answer.count = static_cast<double>(own->cubes.count());
    answer.size = std::to_string(own->cubes.count()) + " cubes, a torus under an even sky";
    answer.values = found.channel[0].exitance[0];
    answer.allowed = 2.0 * forward::embedded::linear_tolerance(cubes_tolerance);
    return answer;
  };
  constexpr double goal = 70e6;
  return {"embedded",
          "cubes",
          "≥ 70 million cubes a second",
          "twice what the linear systems may leave open",
          [](const DeviceAnswer& answer) { return answer.count / answer.seconds >= goal; },
          measure};
}

DeviceTask polygrid(const Request& request) {
  using namespace live_frames;
  constexpr Published bunny = table_3[3];
  constexpr double times = 20.0;
  struct Case {
    std::vector<std::string> warnings;
    render::Scene scene;
    render::World world;
    forward::Polygrid grid;

    Case(const std::string& mesh, int cells)
        : scene(scene_of(mesh)), world(scene, warnings), grid(grid_of(world, cells)) {}
  };
  const int nodes = request.size == Size::quick   ? 8'000
                    : request.size == Size::small ? table_3[0].nodes
                                                  : bunny.nodes;
  const std::vector<std::string> mesh = request.words("mesh");
  const auto own =
      std::make_shared<const Case>(mesh.empty() ? "scenes/meshes/spot.ply" : mesh[0], nodes);
  const auto measure = [=](const Place& place) -> std::optional<DeviceAnswer> {
    DeviceAnswer answer;
    Live live(own->world, own->grid, place.wanted());
    const forward::MediaOfChannels media = volume_of(own->world.objects()[0].mesh, live.cells());
    live.set(media);
    live.frame(first_degrees, Entry::surface);  // compiles
    // Every channel's coefficients are new, then those that all devices have.
    answer.set_up_seconds = median({median_seconds(1,
                                                   [&] {
                                                     live.set({media[1], media[2], media[0]});
                                                   }),
                                    median_seconds(1, [&] { live.set(media); })});
    std::vector<double> elapsed;
    for (const Frame& frame : live.moved_frames(Entry::surface)) {
      elapsed.push_back(1e-3 * frame.diffusion_elapsed);
    }
    answer.seconds = median(elapsed);
    answer.launches =
        launches_in(place, [&] { live.frame(last_degrees + degrees_per_frame, Entry::surface); });
    answer.count = static_cast<double>(live.unknowns());
    answer.size = std::to_string(live.unknowns()) + " nodes, three channels, light moved by 2°";
    live.converge(last_degrees, Entry::surface);
    for (const auto& channel : live.exitance()) {
      answer.values.insert(answer.values.end(), channel.begin(), channel.end());
    }
    answer.allowed = 10.0 * converged.linear_tolerance;
    return answer;
  };
  return {
      "polygrid",
      "nodes",
      "≥ 20 times [W]'s 8800 GTX (23.2 ms)",
      "ten times the tolerance of the compared answers, which OpenCL and the host measure by "
      "other norms",
      [](const DeviceAnswer& answer) { return times * answer.seconds * bunny.diffusion <= 1.0; },
      measure};
}

/// OpenCL alone.
DeviceTask hierarchy(const Request& request) {
  const Quads quads = hierarchy_quads[request.size == Size::full ? 3 : 0];
  const int count = std::max(2, repetitions(request));
  const std::uint64_t seed = request.seed;
  const auto measure = [=](const Place& place) -> std::optional<DeviceAnswer> {
    if (!place.device) return std::nullopt;
    const HierarchyCost cost = hierarchy_cost(context_of(place), quads, count, seed);
    DeviceAnswer answer;
    answer.seconds = 1e-3 * cost.row.at("on_the_fly_ms").get<double>();
    answer.launches = cost.row.at("launches").get<std::size_t>();
    answer.count = cost.row.at("triangles");
    answer.size =
        std::to_string(2 * quads.tube * quads.around) + " triangles, three channels, on the fly";
    for (const Eigen::Array4f& value : cost.exitance) {
      for (int channel = 0; channel < 3; ++channel) {
        answer.values.push_back(static_cast<double>(value[channel]));
      }
    }
    answer.allowed = 1e-5;
    return answer;
  };
  return {"hierarchy",
          "triangles",
          "≤ 3 ms",
          "sums of single precision in another order",
          [](const DeviceAnswer& answer) { return answer.seconds <= 3e-3; },
          measure};
}

// ---- Monte Carlo

/// Photons a second of two cores (AMD EPYC, AVX-512), this task through PoCL.
constexpr double two_cores = 0.36e6;

/// OpenCL alone. A GPU takes more photons: the first launches find out how many it can.
DeviceTask photons(const Request& request) {
  const GridShape shape{96, 96, 24, 0.25};
  const double all = request.size == Size::quick ? 2e4 : request.size == Size::small ? 2e5 : 2e6;
  const int count = std::min(3, repetitions(request));
  const std::uint64_t seed = request.seed;
  const auto measure = [=](const Place& place) -> std::optional<DeviceAnswer> {
    if (!place.device) return std::nullopt;
    constexpr double scattering = 2.62, absorption = 0.0021;  // marble, green
    forward::GridSetup setup;
    setup.shape = shape;
    const Medium medium{Volume<double>(shape, 1.0 / (3.0 * (scattering + absorption))),
                        Volume<double>(shape, absorption)};
    forward::TraceOptions options;
    options.photons = static_cast<std::uint64_t>(all * (place.gpu() ? 100.0 : 1.0));
    options.seed = seed;
    const std::vector<double> light(face_shape(shape, setup.lit_face).cells(), 1.0);
    Progress silent;
    forward::PhotonTally tally;
    const auto trace = [&](const forward::TraceOptions& how) {
      tally = forward::trace_photons(context_of(place), setup, medium, light, 1, how, silent);
    };
    forward::TraceOptions few = options;
    few.photons = 1000;
    trace(few);  // compiles
    DeviceAnswer answer;
    answer.seconds = median_seconds(count, [&] { trace(options); });
    answer.count = static_cast<double>(options.photons);
    answer.size = grid_name(shape) + ", marble of 6 mm, even light";
    if (place.gpu()) answer.note = "100 times the photons";
    double noise = 0.0, norm = 0.0;
    for (const forward::Score& score : tally.exits) {
      answer.values.push_back(score.mean(options.photons));
      noise += std::pow(score.standard_error(options.photons), 2);
      norm += std::pow(answer.values.back(), 2);
    }
    // Two independent maps differ by √2 of their noise.
    answer.allowed = 1.1 * std::sqrt(2.0 * noise / norm);
    return answer;
  };
  return {
      "Monte Carlo",
      "photons",
      "≥ 100 times two cores",
      "the noise of two independent runs, and a tenth more",
      [](const DeviceAnswer& answer) { return answer.count / answer.seconds >= 100.0 * two_cores; },
      measure};
}

}  // namespace

std::string Place::wanted() const {
  return device ? device->platform + " / " + device->name : "reference";
}

std::string Place::shown() const {
  return device ? device->name : "the host, without OpenCL";
}

std::string Place::kind() const {
  return device ? device::to_string(device->kind) : "host";
}

const std::vector<NamedTask>& device_tasks() {
  static const std::vector<NamedTask> all{{"solve", slab},
                                          {"cube", cube},
                                          {"fit", fit},
                                          {"fit-host", fit_host},
                                          {"fit-device", fit_device},
                                          {"embedded", embedded_cubes},
                                          {"polygrid", polygrid},
                                          {"hierarchy", hierarchy},
                                          {"montecarlo", photons}};
  return all;
}

}  // namespace kappamu::studies
