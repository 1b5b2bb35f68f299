// The window of `kappamu view`: objects under lights that a person turns, or a script.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/processor_time.h"
#include "render/live/live_scene.h"

namespace kappamu::app {

struct ViewerOptions {
  std::optional<std::filesystem::path> script;  ///< played with the window hidden
  std::filesystem::path out = ".";              ///< folder of screenshots
  std::string title;                            ///< names what is looked at
  std::optional<std::filesystem::path> edits;   ///< folder that edited volumes are saved to
  std::optional<std::filesystem::path> run;     ///< whose photographs can be shown
  int width = 960, height = 720;                ///< of the picture [px]
  /// The scene once more, as its file has it.
  std::function<std::unique_ptr<render::LiveScene>()> another;
  /// Throws InputError where a file that was dropped on the window cannot be looked at.
  std::function<void(const std::string&)> check = [](const std::string&) {};
  Stopwatch started;  ///< since the command began
};

/// What a viewing cost and left: medians over answers and frames.
struct ViewerTimes {
  int answers = 0, frames = 0;
  double light_ms = 0.0, model_ms = 0.0, frame_ms = 0.0;  ///< frame: drawing and panel
  double event_ms = 0.0;  ///< from a light, edit or shape that changes to its picture, by the clock
  /// From one such picture to the next where changes follow each other, by the clock and by the
  /// processor's time of all threads.
  double picture_ms = 0.0, picture_processor_ms = 0.0;
  std::map<std::string, double> shape_ms{};  ///< answers to shapes that moved, by [M]'s mode
  double first_picture_s = 0.0, first_light_s = 0.0;  ///< since the command began
  double settled_s = 0.0;  ///< when the first answer was as exact as asked
  render::LiveAnswer last;
  std::vector<std::string> models;  ///< that can answer
  std::vector<std::string> screenshots, saved, warnings;
  bool interrupted = false;           ///< by Ctrl-C
  std::optional<std::string> opened;  ///< file that was dropped on the window, to be looked at next
};

/// Makes what is looked at; the shapes are given away before the rest is made.
using LiveMaker =
    std::function<std::unique_ptr<render::LiveScene>(const render::ShapesKnown& shapes_known)>;

/// Until the window is closed or the script ends. Throws InputError as `make`, and where no window
/// can be opened or this build has none.
ViewerTimes view(const render::Scene& scene, const LiveMaker& make, const ViewerOptions& options);

}  // namespace kappamu::app
