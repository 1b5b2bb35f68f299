#include "core/appearance_error.h"

namespace kappamu {

void AppearanceError::add(double predicted, double measured, double variance) {
  misfit += (predicted - measured) * (predicted - measured);
  signal += measured * measured;
  noise += variance;
  ++count;
}

void AppearanceError::add(const AppearanceError& other) {
  misfit += other.misfit;
  signal += other.signal;
  noise += other.noise;
  count += other.count;
}

double AppearanceError::E() const {
  return signal > 0.0 ? misfit / signal : 0.0;
}

double AppearanceError::noise_E() const {
  return signal > 0.0 ? noise / signal : 0.0;
}

}  // namespace kappamu
