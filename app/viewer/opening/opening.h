// The window while its scene is made: shapes are shown as soon as they are known.
#pragma once

#include <memory>

#include "app/viewer/view_state.h"
#include "app/viewer/view_times.h"
#include "app/viewer/viewer.h"
#include "app/viewer/window.h"

namespace kappamu::app {

/// As the window first shows the scene of `state`: what the film's width shows is shown, though the
/// panel takes of it.
ViewState first_state(const render::Scene& scene, ViewState state, const ViewerOptions& options,
                      float scale);

struct Opened {
  std::unique_ptr<Window> window;
  std::unique_ptr<render::LiveScene> live;  ///< none: the window was closed before
};
/// Opens a window and calls `make` on another thread meanwhile. Throws InputError as `make`, and
/// where no window can be opened.
Opened open_window(const render::Scene& scene, const LiveMaker& make, const ViewerOptions& options,
                   ViewTimes& times);

}  // namespace kappamu::app
