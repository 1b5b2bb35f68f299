// What the camera saw of a run's block under each of its patterns, beside what the fitted volume
// predicts there: patterns that were fitted, and those kept out of the fit.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/viewer/panel/panel_picture.h"
#include "app/viewer/view_state.h"

namespace kappamu::app {

class PhotographWindow {
 public:
  /// None where `run` is no run with a fit.
  explicit PhotographWindow(const std::filesystem::path& run);

  int count() const { return static_cast<int>(photographs_.size()); }
  /// As SliceWindow::draw(); there is at least one.
  void draw(float scale, Photograph& photograph);

 private:
  struct Compared {
    std::string pattern;
    bool fitted = false;
    double error = 0.0;  ///< normalised BSSRDF error, [W] 6.1
    int columns = 0, rows = 0;
    std::vector<std::uint8_t> measured, predicted;  ///< R, G, B
  };
  std::vector<Compared> photographs_;
  PanelPicture measured_, predicted_;
};

}  // namespace kappamu::app
