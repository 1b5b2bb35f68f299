// Surfaces behind a glass slide: sample | slide | air, the slide clear, all its internal
// reflections summed incoherently.
#pragma once

#include "core/optics.h"

namespace kappamu::forward {

/// Unpolarised reflectance; `cos_sample` is the cosine of the angle to the normal in the sample.
/// Snell's law makes it the same from outside at the refracted angle. A slide of index 1 is none.
/// Dimensionless.
double slide_reflectance(double n_sample, double n_slide, double cos_sample);

/// Fresnel moments of such a surface, as boundary_constants() has them without a slide.
BoundaryConstants slide_constants(double n_sample, double n_slide);

}  // namespace kappamu::forward
