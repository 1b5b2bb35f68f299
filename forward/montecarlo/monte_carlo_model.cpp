#include "forward/montecarlo/monte_carlo_model.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/optics.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "device/context.h"
#include "forward/montecarlo/photon_tracer.h"

namespace kappamu::forward {

namespace {

/// Above this the fictitious collisions cost more than all else.
constexpr double slow_majorant_ratio = 20.0;

device::Context& context_of(const std::string& device) {
  if (device == "reference") {
    throw InputError(
        "Monte Carlo transport has no serial reference; choose an OpenCL device (pocl-opencl-icd "
        "makes one of the processor)",
        {{"device"}});
  }
  return device::Context::chosen(device);
}

class MonteCarloModel final : public ForwardModel {
 public:
  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                      Progress& progress) const override {
    device::Context& context = context_of(options.device);
    TraceOptions trace;
    trace.photons = options.photons;
    trace.seed = options.seed;
    trace.anisotropy = options.anisotropy;
    trace.light = problem.light;
    trace.fluence = options.fluence;
    trace.cameras = options.cameras;
    const Stopwatch watch;
    const PhotonTally tally = trace_photons(context, problem.setup, problem.medium,
                                            problem.irradiance, problem.patterns, trace, progress);
    const double spent = watch.seconds();

    ForwardResult result;
    result.backend = context.info().name + " (single precision)";
    result.termination = Termination::converged;
    result.photons = options.photons;
    result.seconds = spent;
    result.balance.resize(static_cast<std::size_t>(problem.patterns));
    const std::vector<double> entering =
        entering_power(problem.setup, problem.light, problem.irradiance, problem.patterns);
    double worst = 0.0;
    for (std::size_t m = 0; m < result.balance.size(); ++m) {
      result.balance[m].entering = entering[m];
      worst = std::max(worst, add_pattern(problem, tally, m, result));
    }
    const std::size_t cells = problem.setup.shape.cells();
    for (std::size_t i = 0; i < tally.fluence.size(); ++i) {
      result.fluence.push_back(entering[i / cells] * tally.fluence[i]);
      result.fluence_error.push_back(entering[i / cells] * tally.fluence_error[i]);
    }
    result.message =
        std::to_string(options.photons) +
        formatted(
            " photons per pattern give the light that leaves within %g %% (one standard error)",
            100.0 * worst);
    if (tally.majorant > slow_majorant_ratio * tally.mean_extinction) {
      result.warnings.push_back(
          formatted("the densest voxel extinguishes %g times as much as the "
                    "mean one, which slows Monte Carlo by that factor",
                    tally.majorant / tally.mean_extinction));
    }
    return result;
  }

 private:
  /// Relative standard error of all scattered light that leaves.
  static double add_pattern(const ForwardProblem& problem, const PhotonTally& tally, std::size_t m,
                            ForwardResult& result) {
    const GridShape& shape = problem.setup.shape;
    const double area = shape.voxel_mm * shape.voxel_mm;
    PowerBalance& balance = result.balance[m];
    const auto photons = static_cast<double>(tally.photons);
    const auto power = [&](std::uint64_t weight) {
      return balance.entering * static_cast<double>(weight) / Score::full_weight / photons;
    };
    balance.absorbed = power(tally.totals[m].absorbed);
    balance.unscattered = power(tally.totals[m].unscattered);
    Score all;
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      const std::size_t pixels = face_shape(shape, all_faces[f]).cells();
      const std::size_t first = m * surface_pixels(shape) + first_pixel(shape, all_faces[f]);
      Score face;
      for (std::size_t k = 0; k < pixels; ++k) {
        const Score& pixel = tally.exits[first + k];
        face += pixel;
        if (!tally.view[f].empty()) continue;
        result.exitance[f].push_back(balance.entering / area * pixel.mean(tally.photons));
        const double error = pixel.weight > 0 ? pixel.standard_error(tally.photons) : 1.0 / photons;
        result.standard_error[f].push_back(balance.entering / area * error);
      }
      for (std::size_t k = m * pixels; k < std::min((m + 1) * pixels, tally.view[f].size()); ++k) {
        result.exitance[f].push_back(balance.entering / area * tally.view[f][k]);
        result.standard_error[f].push_back(balance.entering / area * tally.view_error[f][k]);
      }
      balance.exiting[f] = power(face.weight);
      all += face;
    }
    return all.weight > 0 ? all.standard_error(tally.photons) / all.mean(tally.photons) : 0.0;
  }
};

}  // namespace

std::unique_ptr<ForwardModel> make_monte_carlo_model() {
  return std::make_unique<MonteCarloModel>();
}

double standard_error_of_mean(std::span<const double> exitance,
                              std::span<const double> standard_error, double entering,
                              double pixel_area, std::uint64_t photons) {
  const auto n = static_cast<double>(photons);
  const double unit = entering / pixel_area;  // exitance of weight 1 per photon in one pixel
  double first = 0.0, second = 0.0;           // moments of the weight of one photon
  for (std::size_t k = 0; k < exitance.size(); ++k) {
    const double mean = exitance[k] / unit, error = standard_error[k] / unit;
    first += mean;
    if (mean > 0.0) second += error * error * (n - 1.0) + mean * mean;
  }
  return unit * std::sqrt(std::max(0.0, second - first * first) / (n - 1.0)) /
         static_cast<double>(exitance.size());
}

}  // namespace kappamu::forward
