// The size of a picture in its window, and what it depends on.
#pragma once

#include "app/viewer/drawing/canvas.h"
#include "app/viewer/view_state.h"
#include "app/viewer/viewer.h"
#include "app/viewer/window.h"

namespace kappamu::app {

/// Of the picture that is drawn [px], and of the window in its own coordinates.
struct FrameSize {
  int width = 0, height = 0, across = 0, high = 0;
  bool empty() const { return width < 1 || height < 1 || across < 1 || high < 1; }
  float density() const { return static_cast<float>(width) / static_cast<float>(across); }
  /// Where the picture lies in it.
  Viewport viewport(const ViewState& state) const;
  bool operator==(const FrameSize&) const = default;
};
FrameSize frame_size(const Window& window, const ViewerOptions& options);

/// Lays out a window of this size.
void lay_out(const render::Scene& scene, const ViewerOptions& options, int across, int high,
             ViewState& state);

/// What a picture without its panel depends on.
struct PictureDrawn {
  render::PictureView view;
  Viewport at;
  FrameSize size;
  double exposure = 1.0;
  int channel = 0;
  bool traced = false, roughly = false;
  int version = 0;
  bool operator==(const PictureDrawn&) const = default;
};

}  // namespace kappamu::app
