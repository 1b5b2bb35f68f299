// Whether the pictures lie mirrored to the light that made them: a projector set to rear
// projection, photographs flipped by a program. A fit then finds coefficients that no material has,
// after a long time.
#pragma once

#include <optional>
#include <string>

#include "core/surface_measurements.h"

namespace kappamu::inverse {

/// A sentence if, from pattern to pattern, the light that leaves the seen face moves the other way
/// than the light on the lit face, along either axis. Through any block it moves the same way, if
/// less far. Nothing where the faces are not opposite, or too few patterns differ in place.
std::optional<std::string> mirrored_light(const SurfaceMeasurements& measured, int channel);

}  // namespace kappamu::inverse
