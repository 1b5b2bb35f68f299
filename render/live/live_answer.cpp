#include "render/live/live_answer.h"

#include <cmath>

namespace kappamu::render {

std::optional<double> LiveAnswer::error() const {
  if (!error_estimate || !model_error) return error_estimate ? error_estimate : model_error;
  return std::hypot(*error_estimate, *model_error);
}

void LiveAnswer::take_over(LiveAnswer& earlier) {
  moved.merge(earlier.moved);
  if (shape_refused.empty()) shape_refused = earlier.shape_refused;
  if (refused.empty()) refused = earlier.refused;
  if (mode != "static" || earlier.mode == "static") return;
  // A better answer came before anyone saw how the shape was followed.
  mode = earlier.mode;
  caught_up = earlier.caught_up;
  shape_ms = earlier.shape_ms;
  light_ms = earlier.light_ms;
  model_ms = earlier.model_ms;
  surface_ms = earlier.surface_ms;
}

}  // namespace kappamu::render
