// What the picture shows: the last answer as the graphics card draws it, and once it is there, its
// traced picture of the same view.
#pragma once

#include <optional>
#include <vector>

#include "app/viewer/answers.h"
#include "app/viewer/drawing/canvas.h"
#include "app/viewer/fur/fur_canvas.h"
#include "app/viewer/view_state.h"

namespace kappamu::app {

/// The state's view of shapes within `diameter_mm`, without light.
Seen seen_from(const ViewState& state, double diameter_mm);

class Display {
 public:
  /// With a context current; keeps a reference to the world, which is the one that is shown.
  explicit Display(const render::World& world)
      : world_(world), corners_(world), canvas_(corners_.geometry()) {}

  /// Of lights as they were asked about.
  void take(const render::LiveAnswer& answer, const std::vector<render::Light>& lights);
  void take(const Answers::Traced& traced);
  /// The traced picture is of another state.
  void drop_traced() {
    if (traced_) ++version_;
    traced_.reset();
  }

  /// Empties a picture of this size, which others may draw into too.
  void begin(int width, int height, Edges edges) { canvas_.begin(width, height, edges); }
  /// Draws the view at `at`. Without light the shape alone is shaded.
  void draw(const ViewState& state, const render::PictureView& view, bool lit, const Viewport& at);
  void end() { canvas_.end(); }
  void draw_over() { canvas_.draw_over(); }
  /// Another number whenever the same view may look otherwise.
  int version() const { return version_; }
  /// Fur over the objects from now on. Keeps references.
  void show_fur(FurCanvas& canvas, const FurModel& model) {
    fur_canvas_ = &canvas;
    fur_ = &model;
  }
  void show(int window_width, int window_height) const {
    canvas_.show(window_width, window_height);
  }
  /// Waits until it is drawn.
  void finish() const { canvas_.finish(); }
  Image<std::uint8_t> picture() const { return canvas_.picture(); }

 private:
  void take_sky(const std::vector<render::Light>& lights);

  const render::World& world_;
  render::LitCorners corners_;
  Canvas canvas_;
  int version_ = 0;
  FurCanvas* fur_canvas_ = nullptr;
  const FurModel* fur_ = nullptr;
  std::optional<render::EnvironmentLight> sky_;  ///< that the canvas has
  std::optional<render::PictureView> traced_;    ///< of the canvas' traced picture
};

}  // namespace kappamu::app
