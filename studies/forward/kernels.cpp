#include "studies/forward/kernels.h"
#include "studies/forward/bandwidth.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/processor_time.h"
#include "device/context.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"
#include "studies/record.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

/// What a launch on the finest grid reads and writes, per cell of it.
struct Traffic {
  const char* kernel;
  double vectors;         ///< of all patterns, on all cells; half of one on red cells
  double coarse_vectors;  ///< on the cells of the next grid
  double coefficients;    ///< shared by the patterns
};
constexpr std::array<Traffic, 20> traffic{{
    // Streams, on processors: r; r, z; z, p, r, d and p, r, d.
    {"stream_down", 0.5, 1.0, 8.0},
    {"stream_up", 1.0, 1.0, 8.0},
    {"stream_step", 3.5, 0.0, 5.0},
    // b on all cells, red cells of x, d and r, black ones of x; b, red cells of r, black ones of x;
    // red cells of x and d twice.
    {"reduced_residual", 3.0, 0.0, 4.0},
    {"residual_of_zero", 2.0, 0.0, 4.0},
    {"renormalise_red", 2.0, 0.0, 0.0},
    // Kernel by kernel, on GPUs: vectors by colour, a stencil's eight numbers of one colour; of
    // reds around black cells the smoother alone.
    {"solve_black_first", 1.0, 0.0, 4.5},
    {"residual_of_first", 1.5, 0.0, 4.0},
    {"restrict_residual", 0.5, 1.0, 1.5},
    {"correct_first", 1.0, 1.0, 5.5},
    {"solve_black", 1.0, 0.0, 4.0},
    {"relax_and_sum", 2.0, 0.0, 4.0},
    {"next_direction", 1.5, 0.0, 0.0},
    {"solve_black_of_direction", 1.5, 0.0, 4.0},
    {"image_of_direction", 2.0, 0.0, 4.0},
    {"update", 3.0, 0.0, 0.0},
    // φ on red cells and d twice; red d and b, φ on all, black d; φ, d, b on red cells, r.
    {"renormalise", 2.0, 0.0, 0.0},
    {"solve_black_accurately", 2.5, 0.0, 4.0},
    {"true_residual", 3.0, 0.0, 4.0},
    {"squares", 1.0, 0.0, 0.0},
}};

/// Whether a launch works on the finest grid: its integers name that grid's extents, or its cells.
bool on_finest(const device::LaunchTime& launch, const GridShape& shape) {
  const std::array<int, 3> extents{shape.nx, shape.ny, shape.nz};
  const auto& named = launch.integers;
  const auto cells = static_cast<int>(shape.cells()),
             reds = static_cast<int>(forward::half_cells(shape));
  return std::search(named.begin(), named.end(), extents.begin(), extents.end()) != named.end() ||
         std::find(named.begin(), named.end(), cells) != named.end() ||
         std::find(named.begin(), named.end(), reds) != named.end();
}

}  // namespace

std::optional<double> kernel_bytes(const std::string& kernel, std::size_t cells,
                                   std::size_t coarse_cells, int lanes, std::size_t real_bytes) {
  for (const Traffic& t : traffic) {
    if (kernel != t.kernel) continue;
    const double vectors = t.vectors * static_cast<double>(cells) +
                           t.coarse_vectors * static_cast<double>(coarse_cells);
    return static_cast<double>(real_bytes) *
           (vectors * lanes + t.coefficients * static_cast<double>(cells));
  }
  return std::nullopt;
}

double KernelProfile::finest_fraction() const {
  double bytes = 0.0, seconds = 0.0;
  for (const KernelUse& use : finest) {
    if (!use.bytes) continue;
    bytes += use.launches * *use.bytes;
    seconds += use.solve_seconds;
  }
  return seconds > 0.0 ? bytes / (seconds * bandwidth) : 0.0;
}

KernelProfile profile_kernels(const ProblemSpec& spec, const std::string& device,
                              forward::Precision precision, int repetitions) {
  const bool single = precision == forward::Precision::single_precision;
  forward::GridSetup setup;
  setup.shape = spec.shape;
  const auto choice = forward::make_grid_solver(setup, device, precision);
  if (!choice.warning.empty()) throw InputError(choice.warning);
  device::Context& context = device::Context::chosen(device);
  const forward::GridSolver& solver = *choice.solver;
  const Medium medium = make_medium(spec.shape, spec.medium);
  choice.solver->set_medium(medium.kappa.values(), medium.mu.values());
  const auto b = solver.make_field(spec.patterns);
  solver.light_source(patch_light(spec.shape, setup.lit_face, spec.patterns), *b);

  KernelProfile profile;
  profile.precision = single ? "single" : "double";
  profile.bandwidth = measured_copy_bandwidth(context);
  std::vector<double> walls;
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> seconds;
  const auto solve = [&] {
    const auto phi = solver.make_field(spec.patterns);
    const Stopwatch watch;
    profile.iterations = solver.solve(*b, *phi, {1e-6, 400}).iterations;
    walls.push_back(watch.seconds());
  };
  solve();  // compiles
  walls.clear();
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    for (const device::LaunchTime& launch : context.launches_of(solve)) {
      if (!on_finest(launch, spec.shape)) {
        profile.coarse_seconds += launch.seconds / repetitions;
        continue;
      }
      auto& list = seconds[launch.kernel];
      if (list.empty()) order.push_back(launch.kernel);
      list.push_back(launch.seconds);
    }
  }
  profile.bandwidth = std::max(profile.bandwidth, measured_copy_bandwidth(context));
  profile.solve_seconds = median(walls);
  const std::size_t coarse_cells = forward::coarser_grid(spec.shape).cells();
  for (const std::string& kernel : order) {
    const std::vector<double>& list = seconds[kernel];
    KernelUse use{kernel, static_cast<double>(list.size()) / repetitions, median(list), 0.0,
                  kernel_bytes(kernel, spec.shape.cells(), coarse_cells, spec.patterns,
                               single ? sizeof(float) : sizeof(double))};
    for (const double one : list) use.solve_seconds += one / repetitions;
    profile.finest.push_back(use);
  }
  return profile;
}

Json to_json(const KernelProfile& profile) {
  Json kernels = Json::array();
  for (const KernelUse& use : profile.finest) {
    Json entry{{"kernel", use.kernel},
               {"launches_per_solve", use.launches},
               {"seconds_per_launch", use.seconds},
               {"seconds_per_solve", use.solve_seconds}};
    if (use.bytes) {
      entry["bytes_per_launch"] = *use.bytes;
      entry["bandwidth_fraction"] = *use.bytes / (use.seconds * profile.bandwidth);
    }
    kernels.push_back(entry);
  }
  return {{"precision", profile.precision},
          {"iterations", profile.iterations},
          {"solve_seconds", profile.solve_seconds},
          {"coarse_seconds", profile.coarse_seconds},
          {"copy_bandwidth_bytes_per_second", profile.bandwidth},
          {"finest_bandwidth_fraction", profile.finest_fraction()},
          {"kernels", kernels}};
}

}  // namespace kappamu::studies
