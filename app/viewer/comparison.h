// Another state of the scene left of the one in hand: the scene as its file has it, or as it was at
// some moment. Its media, shapes and model stay; its light and camera are those in hand.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/answers.h"
#include "app/viewer/drawing/display.h"
#include "render/live/live_scene.h"

namespace kappamu::app {

class Comparison {
 public:
  /// With a context current. `ready`: as Answers has it.
  Comparison(std::unique_ptr<render::LiveScene> scene, render::LiveQuestion held, std::string name,
             std::function<void()> ready);

  /// Other lights from now on.
  void light(const std::vector<render::Light>& lights);
  void look(const std::optional<render::PictureView>& view) { answers_.look(view); }
  /// Takes what was answered. Whether the picture changes.
  bool update();
  bool waiting() const { return answers_.waiting(); }
  /// Whether a better picture may come; of a view that stands still, a traced one too.
  bool improving() const { return answers_.refining() || answers_.tracing(); }

  /// Between the begin() and the end() of the display in hand.
  void draw(const ViewState& state, const render::PictureView& view, const Viewport& at) {
    display_.draw(state, view, answer_.has_value(), at);
  }
  /// The state, its model, and its error or what is being computed.
  std::string label() const;

 private:
  std::unique_ptr<render::LiveScene> scene_;
  render::LiveQuestion held_;
  std::string name_;
  Display display_;
  std::optional<render::LiveAnswer> answer_;
  Answers answers_;
};

}  // namespace kappamu::app
