// A state of the scene as it is shown: what is asked of it, its last answer, its fur, and both
// drawn.
#pragma once

#include <functional>
#include <optional>

#include "app/viewer/answers.h"
#include "app/viewer/drawing/display.h"
#include "app/viewer/fur/fur_canvas.h"
#include "app/viewer/fur/fur_model.h"

namespace kappamu::app {

class Shown {
 public:
  /// With a context current. Keeps a reference to `live`, which is of `scene` but for its fur.
  /// `ready`: as Answers has it.
  Shown(const render::Scene& scene, render::LiveScene& live, std::function<void()> ready);

  void ask(render::LiveQuestion question);
  void look(const std::optional<render::PictureView>& view) { answers_.look(view); }
  bool waiting() const { return answers_.waiting(); }
  /// Whether a better picture may come; of a view that stands still, a traced one too.
  bool improving() const { return answers_.refining() || answers_.tracing(); }
  /// Whether a better answer may come.
  bool refining() const { return answers_.refining(); }
  bool making_fur() const { return fur_.making(); }
  std::optional<Answers::Work> work_now() const { return answers_.work_now(); }

  // What has come since the last call. Whether the picture changes.
  /// Shapes of an answer are those of the live scene's world from then on.
  bool take_answer();
  bool take_picture();
  bool update_fur();
  /// Waits for the finest fur.
  void finish_fur();

  /// That the picture shows; none yet.
  const render::LiveAnswer* answer() const { return answer_ ? &*answer_ : nullptr; }
  /// Where fur is drawn; none: there is no fur.
  FurCanvas* fur_canvas() { return fur_canvas_ ? &*fur_canvas_ : nullptr; }
  FurModel& fur() { return fur_; }
  const Display& display() const { return display_; }
  Display& display() { return display_; }
  /// Between a display's begin() and end(), of this or of another state.
  void draw(const ViewState& state, const render::PictureView& view, const Viewport& at) {
    display_.draw(state, view, answer_.has_value(), at);
  }

 private:
  /// With what fur leaves of the skin's light, now.
  void show();

  render::LiveScene& live_;
  Display display_;
  FurModel fur_;
  std::optional<FurCanvas> fur_canvas_;
  std::vector<render::Light> lights_;         ///< that were asked about
  std::optional<render::LiveAnswer> answer_;  ///< that the picture shows
  Answers answers_;
};

}  // namespace kappamu::app
