#include "app/viewer/panels.h"

#include "app/viewer/fur/fur_group.h"
#include "app/viewer/overlay.h"

namespace kappamu::app {

Panels::Panels(render::LiveScene& live, const ViewerOptions& options, Editing& editing,
               Shaping& shaping, Shown& shown, const render::Camera& home)
    : live_(live), editing_(editing), shown_(shown), home_(home) {
  if (options.run) photographs_.emplace(*options.run);
  groups_.push_back(light_group());
  groups_.push_back(view_group(photograph_count() > 0));
  groups_.push_back(shape_group(shaping));
  groups_.push_back(edit_group(editing.painter()));
  groups_.push_back(material_group(editing.painter()));
  groups_.push_back(model_group(render::live_models(live.world())));
  if (FurCanvas* fur_canvas = shown.fur_canvas()) {
    groups_.push_back(fur_group(shown.fur(), editing.painter(), *fur_canvas));
  }
}

void Panels::draw(const Beside& beside, double frame_ms, const std::string& note,
                  ViewState& state) {
  if (state.docked && state.marks_shown) {
    draw_marks(state);
    if (beside.shown()) draw_names(state, beside.label());
  }
  if (state.docked) draw_status(state, shown_.answer(), live_.tolerance(), shown_.work_now());
  if (!state.panel) return;
  const PanelNumbers numbers{shown_.answer(), frame_ms, note.empty() ? editing_.note() : note};
  editing_.obey_panel(draw_panel(groups_, numbers, state), state);
  if (state.slice.shown) {
    Painter& painter = editing_.painter();
    const std::size_t edited = painter.in_hand();
    slices_.draw(painter.edited(edited).history().volume(), painter.axes(edited), home_,
                 state.scale, state.slice);
  }
  if (state.photograph.shown) photographs_->draw(state.scale, state.photograph);
}

}  // namespace kappamu::app
