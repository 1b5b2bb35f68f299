// What a person or a script does with edits: strokes, previews, undo, saving, closing. What cannot
// be done is noted, and the window keeps what it holds; a script ends there.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/viewer/painter.h"
#include "app/viewer/panel.h"
#include "app/viewer/view_state.h"
#include "app/viewer/viewer.h"

namespace kappamu::app {

class Editing {
 public:
  /// `changed` is called where media changed. Continues with the edits of earlier windows. Throws
  /// InputError where their folder is unusable.
  Editing(const render::Scene& scene, const render::World& world, const ViewerOptions& options,
          std::function<void()> changed);

  Painter& painter() { return painter_; }
  const std::string& note() const { return note_; }

  /// Through points as Painter::stroke_through() has them.
  void stroke_through(const render::LookAt& look, const std::vector<Eigen::Vector2d>& points,
                      const Brush& brush);
  Painter::Stroked end_stroke();
  void preview(const render::Edit& edit);
  void keep_lights(const std::vector<render::Light>& lights) { painter_.keep_lights(lights); }
  void change_fur(std::size_t object, const render::FurChange& change);
  /// By the panel: what it shows is kept, though it was changed since the preview.
  void obey_panel(Asked asked, const ViewState& state);
  void obey(Asked asked, const std::string& folder);
  /// Whether the window may close.
  bool close(Closing closing, const std::string& folder);

  /// Files that were written, and warnings; those of unsaved edits with them where the window is
  /// interrupted.
  const std::vector<std::string>& saved() const { return saved_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  void interrupted();

 private:
  static Painter opened(const render::Scene& scene, const render::World& world,
                        const ViewerOptions& options);
  bool save(const std::string& folder);

  /// Whether it was done.
  template <class Action>
  bool attempt(const Action& action);

  ViewerOptions options_;
  std::function<void()> changed_;
  Painter painter_;
  std::string note_;
  std::vector<std::string> saved_, warnings_;
};

}  // namespace kappamu::app
