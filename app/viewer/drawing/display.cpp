#include "app/viewer/drawing/display.h"

#include <algorithm>
#include <variant>

namespace kappamu::app {

void Display::take(const render::LiveAnswer& answer, const std::vector<render::Light>& lights) {
  ++version_;
  traced_.reset();
  if (!answer.moved.empty()) canvas_.set_geometry(corners_.geometry());
  canvas_.set_light(corners_, answer);
  take_sky(lights);
}

void Display::take(const Answers::Traced& traced) {
  ++version_;
  canvas_.set_traced(traced.picture.radiance);
  traced_ = traced.view;
}

void Display::take_sky(const std::vector<render::Light>& lights) {
  std::optional<render::EnvironmentLight> sky;
  for (const render::Light& light : lights) {
    if (const auto* found = std::get_if<render::EnvironmentLight>(&light)) sky = *found;
  }
  const bool same = sky.has_value() == sky_.has_value() &&
                    (!sky || (sky->image == sky_->image && sky->visible == sky_->visible &&
                              (sky->radiance == sky_->radiance).all()));
  if (!same) {
    canvas_.set_sky(render::make_environment(lights));
  } else if (sky && sky->turn_deg != sky_->turn_deg) {
    canvas_.turn_sky(sky->turn_deg);
  }
  sky_ = sky;
}

Seen seen_from(const ViewState& state, double diameter_mm) {
  const double distance = (state.camera.position_mm - state.centre).norm();
  Seen seen;
  seen.camera = state.camera;
  seen.channel = state.channel;
  seen.near_mm = std::max(0.01 * distance, distance - diameter_mm);
  seen.far_mm = distance + diameter_mm;
  return seen;
}

void Display::draw(const ViewState& state, const render::PictureView& view, bool lit,
                   const Viewport& at) {
  Seen seen = seen_from(state, world_.diameter());
  if (lit) seen.exposure = state.exposure;
  seen.traced = lit && state.traced && traced_ == view;
  if (fur_ != nullptr && lit && !seen.traced) {
    fur_canvas_->draw(canvas_, seen, at, *fur_);
  } else {
    canvas_.draw(seen, at);
  }
}

}  // namespace kappamu::app
