// Another state of the scene left of the one in hand: the scene as its file has it, or as it was at
// some moment. Its media, shapes, fur and model stay; its light and camera are those in hand.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/drawing/shown.h"
#include "render/live/live_scene.h"

namespace kappamu::app {

class Comparison {
 public:
  /// With a context current. `live` is of `scene`, which has the state's fur. `ready`: as Answers
  /// has it.
  Comparison(const render::Scene& scene, std::unique_ptr<render::LiveScene> live,
             render::LiveQuestion held, std::string name, std::function<void()> ready);

  /// Other lights from now on.
  void light(const std::vector<render::Light>& lights);
  Shown& shown() { return shown_; }
  /// The state, its model, and its error or what is being computed.
  std::string label() const;

 private:
  std::unique_ptr<render::LiveScene> scene_;
  render::LiveQuestion held_;
  std::string name_;
  Shown shown_;
};

/// The scene as its file has it, under the lights of `now`, or as it is now, with fur as `fur_of`
/// an object gives it.
std::unique_ptr<Comparison> compared_with(Compared with, render::Scene scene,
                                          std::unique_ptr<render::LiveScene> live,
                                          render::LiveQuestion now,
                                          const std::function<render::Fur(std::size_t)>& fur_of,
                                          std::function<void()> ready);

/// The state beside the one in hand, or none.
class Beside {
 public:
  void show(std::unique_ptr<Comparison> comparison) { comparison_ = std::move(comparison); }
  bool shown() const { return comparison_ != nullptr; }
  std::string label() const { return comparison_->label(); }

  // As Shown has them; of none nothing goes on.
  void light(const std::vector<render::Light>& lights) const {
    if (comparison_) comparison_->light(lights);
  }
  void look(const std::optional<render::PictureView>& view) const {
    if (comparison_) comparison_->shown().look(view);
  }
  bool waiting() const { return comparison_ && comparison_->shown().waiting(); }
  bool improving() const { return comparison_ && comparison_->shown().improving(); }
  bool making_fur() const { return comparison_ && comparison_->shown().making_fur(); }
  /// Takes what was answered. Whether the picture changes.
  bool update() const {
    if (!comparison_) return false;
    Shown& shown = comparison_->shown();
    return shown.take_answer() || shown.take_picture() || shown.update_fur();
  }
  void finish_fur() const {
    if (comparison_) comparison_->shown().finish_fur();
  }
  /// Left of `at`, with shells as far apart as those of `in_hand`.
  void draw(const ViewState& state, const render::PictureView& view, Viewport at, Shown& in_hand);

 private:
  std::unique_ptr<Comparison> comparison_;
};

}  // namespace kappamu::app
