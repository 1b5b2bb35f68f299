// A picture in a panel.
#pragma once

#include <cstdint>
#include <vector>

namespace kappamu::app {

class PanelPicture {
 public:
  /// R, G, B of each pixel, the top row first, shown `width` × `height` large. Between ImGui's
  /// NewFrame and Render, with a context current.
  void draw(const std::vector<std::uint8_t>& pixels, int columns, int rows, float width,
            float height);

 private:
  unsigned texture_ = 0;
};

}  // namespace kappamu::app
