#include "app/viewer/comparison.h"

#include <cstdio>
#include <utility>

namespace kappamu::app {

Comparison::Comparison(std::unique_ptr<render::LiveScene> scene, render::LiveQuestion held,
                       std::string name, std::function<void()> ready)
    : scene_(std::move(scene)),
      held_(std::move(held)),
      name_(std::move(name)),
      display_(scene_->world()),
      answers_(*scene_, std::move(ready)) {
  answers_.ask(held_);
}

void Comparison::light(const std::vector<render::Light>& lights) {
  held_.lights = lights;
  display_.drop_traced();
  answers_.ask(held_);
}

bool Comparison::update() {
  std::optional<render::LiveAnswer> answer = answers_.take();
  if (answer) {
    if (!answer->moved.empty()) scene_->show(*answer);
    display_.take(*answer, held_.lights);
    answer_ = std::move(answer);
    return true;
  }
  const std::optional<Answers::Traced> traced = answers_.take_picture();
  if (traced) display_.take(*traced);
  return traced.has_value();
}

std::string Comparison::label() const {
  std::string text = name_;
  if (answer_) text += ": " + answer_->model;
  if (answer_ && !answer_->refused.empty()) text += ", " + answer_->refused;
  if (answer_ && !answer_->shape_refused.empty()) text += ", " + answer_->shape_refused;
  char number[48] = "";
  if (const auto work = answers_.work_now()) {
    std::snprintf(number, sizeof(number), ", %s %.0f %%", work->refining ? "sharpening" : "solving",
                  100.0 * work->fraction);
  } else if (answer_ && answer_->error()) {
    std::snprintf(number, sizeof(number), ", error up to %.2g %%", 100.0 * *answer_->error());
  }
  return text + number;
}

}  // namespace kappamu::app
