// What `kappamu view --script` plays in place of a person: one command per line, # begins a
// comment.
//
//   lamp N            takes hold of the N-th light, from 1
//   light AZ EL       turns it to these angles [degrees]
//   orbit DX DY       turns the camera about its target [degrees]
//   exposure E        factor before the tone curve
//   panel on|off      the panel of numbers
//   brush OPERATION kappa|mu AMOUNT RADIUS DEPTH   takes a brush in hand [mm]: multiply, add, set
//   or blend paint X Y [X Y ...]   a stroke through points of the picture, from its top left corner
//   [px] undo, redo        of strokes slice NAME x|y|z N    the slice across an axis at a voxel, of
//   a volume such as mu_R save              edited volumes and recipes, as --edits says screenshot
//   NAME   writes the picture as PNG, once it is of the light as it stands quit
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "app/viewer/painter.h"

namespace kappamu::app::script {

struct Lamp {
  int number = 1;
};
struct TurnLight {
  double azimuth_deg = 0.0, elevation_deg = 0.0;
};
struct Orbit {
  double right_deg = 0.0, up_deg = 0.0;
};
struct Exposure {
  double factor = 1.0;
};
enum class Panel { on, off };
struct Screenshot {
  std::string name;
};
struct Paint {
  std::vector<double> points;  ///< x, y, x, y, ... [px]
};
struct Undo {};
struct Redo {};
struct ShowSlice {
  std::string volume;
  int axis = 2, index = 0;
};
struct Save {};
struct Quit {};

using Command = std::variant<Lamp, TurnLight, Orbit, Exposure, Panel, Screenshot, Brush, Paint,
                             Undo, Redo, ShowSlice, Save, Quit>;

/// Throws InputError naming file and line.
std::vector<Command> read(const std::filesystem::path& file);

}  // namespace kappamu::app::script
