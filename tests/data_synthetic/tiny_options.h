// The small, quick simulated capture of tests.
#pragma once

#include "data_synthetic/simulation_options.h"

namespace kappamu::synthetic {

/// Sample "tiny", 2 × 2 patches, five exposures, a small camera and projector.
inline SimulationOptions tiny_options() {
  SimulationOptions options;
  options.sample = "tiny";
  options.light = {capture::LightShape::patches, 2};
  options.exposures_s = SimulationOptions::geometric_exposures(1.0 / 30.0, 8.0, 5);
  options.projector_size = {640, 480};
  options.board_views = 12;
  options.projector_planes = 8;
  options.holdout = 4;
  return options;
}

}  // namespace kappamu::synthetic
