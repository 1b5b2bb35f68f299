#include "inverse/fit/fit_memory.h"

#include <algorithm>

#include "core/process_memory.h"
#include "device/device_info.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::memory;

}  // namespace

FitMemory memory_needed(const SurfaceMeasurements& measurements, const FitOptions& options) {
  const Backend& backend = options.solver.backend;
  const auto operators = backend.operators ? backend.operators : forward::block_operators();
  const forward::GridSetup setup{.shape = measurements.grid, .lit_face = measurements.lit_face};
  const auto cells = static_cast<double>(measurements.grid.cells());
  const int patterns = measurements.patterns;
  const int batch = std::min(patterns, backend.batch);
  const auto solver = [&](const forward::GridSetup& at, int fields, int in_fields, int at_once) {
    return static_cast<double>(
        operators->memory(at, in_fields, fields, at_once, backend.precision));
  };
  // φ of all patterns stays while an adjoint batch, or a refined one, is solved beside it.
  const double fluence = solver(setup, 1, patterns, batch);
  const double real = backend.precision == forward::Precision::single_precision ? 4.0 : 8.0;
  const double adjoint = 2.0 * real * cells * batch;
  double refined = 0.0;
  double refined_host = 0.0;
  if (options.path.correct_grid) {
    forward::GridSetup finer = setup;
    finer.shape = setup.shape.refined(2);
    const int at_once =
        bounded_batch(finer.shape, backend.batch, backend.refined_memory_mb, backend.precision);
    refined = solver(finer, 2, std::min(patterns, at_once), std::min(patterns, at_once));
    refined_host = 8.0 * 8.0 * refined_doubles * cells;
  }
  // Pairs of steps and changes of the gradient, two coefficients each.
  const double pairs = 2.0 * 2.0 * options.solver.optimiser.memory;
  return {fluence + std::max(adjoint, refined),
          8.0 * cells * (working_doubles + pairs) + refined_host};
}

int fits_at_once(const FitMemory& of_one, const Backend& backend, int channels) {
  constexpr double share = 0.5;
  double most = share * main_memory() / of_one.total();
  const auto devices = device::list_devices();
  if (backend.device != "reference" && !devices.empty()) {
    const device::DeviceInfo& d = devices[device::choose(devices, backend.device).index];
    most = std::min(most, share * static_cast<double>(d.global_memory_bytes) / of_one.device);
  }
  return std::clamp(static_cast<int>(std::min(most, 64.0)), 1, channels);
}

std::string in_words(const FitMemory& memory) {
  return "about " + gigabytes(memory.total()) + " of memory at the peak";
}

std::optional<std::string> warning_of(const FitMemory& memory, double available) {
  if (memory.total() <= available) return std::nullopt;
  return "the fit needs about " + gigabytes(memory.total()) + " of memory, this machine has " +
         gigabytes(available) + "; fit a coarser grid or fewer patterns";
}

}  // namespace kappamu::inverse
