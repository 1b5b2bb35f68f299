// The panel's group of fur: what the hair is like, the brush, what it costs.
#pragma once

#include <memory>

#include "app/viewer/fur/fur_canvas.h"
#include "app/viewer/painter.h"
#include "app/viewer/panel.h"

namespace kappamu::app {

/// Of a scene with fur. Keeps references. A slider shows its effect while it is dragged, and adds
/// an edit when it is let go.
std::unique_ptr<PanelGroup> fur_group(FurModel& model, Painter& painter, FurCanvas& canvas);

}  // namespace kappamu::app
