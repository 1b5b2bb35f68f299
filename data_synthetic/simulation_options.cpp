#include "data_synthetic/simulation_options.h"

#include <cmath>

#include "core/error.h"

namespace kappamu::synthetic {

std::vector<double> SimulationOptions::geometric_exposures(double first, double last, int count) {
  std::vector<double> exposures;
  exposures.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    exposures.push_back(count == 1 ? first : first * std::pow(last / first, i / (count - 1.0)));
  }
  return exposures;
}

namespace {

std::string number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

void within(const std::string& option, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw InputError(option + " is " + number(value) + ": choose a value from " + number(low) +
                     " to " + number(high));
  }
}

}  // namespace

void validate(const SimulationOptions& options) {
  const bool bars = options.light.shape == capture::LightShape::bars;
  if (options.light.shape == capture::LightShape::sinusoids) {
    for (const double per_mm : options.light.sinusoids.per_mm) {
      within("sinusoids", per_mm, 1e-3, 10);
    }
    within("phases", options.light.sinusoids.phases, 3, 36);
  } else {
    within(bars ? "bars" : "patches", options.light.n, 1, bars ? 64 : 16);
  }
  within("anisotropy", options.anisotropy, -0.95, 0.95);
  if (options.anisotropy != 0.0 && options.transport != TransportMethod::monte_carlo) {
    throw InputError("anisotropy is " + number(options.anisotropy) +
                     ", and diffusion knows reduced scattering alone: choose montecarlo");
  }
  within("noise", options.noise_scale, 0, 10);
  within("bit depth", options.bit_depth, 8, 16);
  within("boards", options.board_views, 3, 60);
  within("planes", options.projector_planes, 3, 40);
  within("projector gamma", options.projector_gamma, 0.2, 5);
  within("projector levels", options.projector_levels, 0, 254);
  within("room light", options.room_light, 0, 1);
  within("room change", options.room_change, -1, 10);
  within("rays per side", options.rays_per_side, 1, 8);
  within("refinement", options.refinement, 2, 4);
  within("photons", static_cast<double>(options.photons), 1000, 4294967295.0);
  if (options.both_faces && options.room_light > 0.0) {
    throw InputError(
        "both faces are photographed in a dark room: room light would be subtracted "
        "on one of them alone");
  }
  within("surface reflectance", options.surface_reflectance, 0, 0.5);
  within("holdout", options.holdout, 0, 16);
  within("projector width", options.projector_size[0], 320, 8192);
  within("projector height", options.projector_size[1], 240, 8192);
  if (options.camera_size) {
    within("camera width", (*options.camera_size)[0], 320, 8192);
    within("camera height", (*options.camera_size)[1], 240, 8192);
  }
  if (options.grid) {
    for (const int extent : *options.grid) within("grid", extent, 4, 1024);
  }
  if (options.exposures_s.empty()) throw InputError("exposures are empty: give at least one time");
  double previous = 0.0;
  for (const double exposure : options.exposures_s) {
    if (!(exposure > previous)) {
      throw InputError("exposures must be positive and rising: " + number(exposure) +
                       " s follows " + number(previous) + " s");
    }
    previous = exposure;
  }
}

}  // namespace kappamu::synthetic
