// A model of objects from outside kappamu's tree: light leaves where it entered, as from a
// Lambertian surface. It is what every BSSRDF becomes on an object so large that light's paths
// inside are points.
#pragma once

#include "forward/registry.h"

/// Its description, for kappamu::forward::add_object_model().
kappamu::forward::ModelDescription lambert_model();
