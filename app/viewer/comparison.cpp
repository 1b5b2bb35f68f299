#include "app/viewer/comparison.h"

#include <utility>

#include "app/viewer/panel/shown_error.h"

namespace kappamu::app {

Comparison::Comparison(const render::Scene& scene, std::unique_ptr<render::LiveScene> live,
                       render::LiveQuestion held, std::string name, std::function<void()> ready)
    : scene_(std::move(live)),
      held_(std::move(held)),
      name_(std::move(name)),
      shown_(scene, *scene_, std::move(ready)) {
  shown_.ask(held_);
}

std::unique_ptr<Comparison> compared_with(Compared with, render::Scene scene,
                                          std::unique_ptr<render::LiveScene> live,
                                          render::LiveQuestion now,
                                          const std::function<render::Fur(std::size_t)>& fur_of,
                                          std::function<void()> ready) {
  if (with == Compared::unedited) {
    render::LiveQuestion unedited;
    unedited.lights = std::move(now.lights);
    now = std::move(unedited);
  } else {
    now.shape.moving = false;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      if (scene.objects[i].fur) scene.objects[i].fur = fur_of(i);
    }
  }
  return std::make_unique<Comparison>(scene, std::move(live), std::move(now),
                                      with == Compared::kept ? "as it was" : "unedited",
                                      std::move(ready));
}

void Comparison::light(const std::vector<render::Light>& lights) {
  held_.lights = lights;
  shown_.ask(held_);
}

std::string Comparison::label() const {
  std::string text = name_;
  const render::LiveAnswer* answer = shown_.answer();
  if (answer) text += ": " + answer->model;
  if (answer && !answer->refused.empty()) text += ", " + answer->refused;
  if (answer && !answer->shape_refused.empty()) text += ", " + answer->shape_refused;
  if (const auto work = shown_.work_now()) {
    text += formatted(", %s %.0f %%", work->refining ? "sharpening" : "solving",
                      100.0 * work->fraction);
  } else if (answer && answer->error()) {
    text += ", error up to " + shown_error(*answer->error());
  }
  return text;
}

void Beside::draw(const ViewState& state, const render::PictureView& view, Viewport at,
                  Shown& in_hand) {
  if (!comparison_) return;
  at.x -= at.width;
  Shown& other = comparison_->shown();
  if (other.fur_canvas() != nullptr) other.fur_canvas()->apart_px = in_hand.fur_canvas()->apart_px;
  other.draw(state, view, at);
}

}  // namespace kappamu::app
