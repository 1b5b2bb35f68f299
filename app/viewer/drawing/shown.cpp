#include "app/viewer/drawing/shown.h"

#include <utility>

namespace kappamu::app {

Shown::Shown(const render::Scene& scene, render::LiveScene& live, std::function<void()> ready)
    : live_(live),
      display_(live.world()),
      fur_(scene, live.world()),
      answers_(live, std::move(ready)) {
  if (fur_.any()) display_.show_fur(fur_canvas_.emplace(), fur_);
}

void Shown::ask(render::LiveQuestion question) {
  display_.drop_traced();
  lights_ = question.lights;
  fur_.set_lights(lights_);
  answers_.ask(std::move(question));
}

bool Shown::take_answer() {
  std::optional<render::LiveAnswer> answer = answers_.take();
  if (!answer) return false;
  answer_ = std::move(answer);
  if (!answer_->moved.empty()) {
    live_.show(*answer_);
    fur_.moved();
  }
  show();
  return true;
}

bool Shown::take_picture() {
  const std::optional<Answers::Traced> traced = answers_.take_picture();
  if (traced) display_.take(*traced);
  return traced.has_value();
}

bool Shown::update_fur() {
  const bool changed = fur_.update();
  if (changed && answer_) show();
  return changed;
}

void Shown::finish_fur() {
  fur_.finish();
  if (fur_.any() && answer_) show();
}

void Shown::show() {
  if (!fur_.any()) return display_.take(*answer_, lights_);
  render::LiveAnswer under_fur = *answer_;
  fur_.shade(under_fur);
  display_.take(under_fur, lights_);
}

}  // namespace kappamu::app
