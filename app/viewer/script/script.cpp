#include "app/viewer/script/script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/file_name.h"
#include "io/json_node.h"
#include "io/read_file.h"
#include "io/text_stream.h"
#include "render/deform/deform_file.h"

namespace kappamu::app::script {

namespace {

std::optional<Command> brush_of(std::istringstream& words) {
  using render::Operation;
  Brush brush;
  std::string operation, of;
  if (!(words >> operation >> of >> brush.amount >> brush.radius_mm >> brush.depth_mm))
    return std::nullopt;
  const auto term = value_of(brush_terms, of);
  if (!term) return std::nullopt;
  brush.of = *term;
  for (const Operation known :
       {Operation::multiply, Operation::add, Operation::set, Operation::blend}) {
    if (operation != name_of(render::operation_names, known)) continue;
    brush.operation = known;
    if (brush.radius_mm > 0.0 && brush.depth_mm > 0.0) return brush;
  }
  return std::nullopt;
}

std::optional<Command> deform_of(std::istringstream& words, const std::filesystem::path& folder) {
  Deform deform;
  std::string file, moving;
  if (!(words >> deform.object >> file)) return std::nullopt;
  const io::JsonDocument document(folder / file, "docs/scene.md", io::JsonComments::allowed);
  deform.deformations = render::read_deformations(document.root());
  if (words >> moving) {
    if (moving != "moving") return std::nullopt;
    deform.moving = true;
  }
  words.clear();
  return deform;
}

std::optional<Command> fur_of(std::istringstream& words) {
  static const std::map<std::string, double render::Fur::*> numbers{
      {"length", &render::Fur::length_mm},    {"density", &render::Fur::density},
      {"width", &render::Fur::width},         {"curl", &render::Fur::curl},
      {"lean", &render::Fur::lean},           {"shine", &render::Fur::shine},
      {"variation", &render::Fur::variation}, {"comb_turn", &render::Fur::comb_turn_deg}};
  static const std::map<std::string, render::Colour render::Fur::*> colours{
      {"root_colour", &render::Fur::root_colour}, {"tip_colour", &render::Fur::tip_colour}};
  std::string field;
  SetFur set;
  words >> field;
  if (const auto found = numbers.find(field); found != numbers.end() && words >> set.value) {
    set.field = found->second;
    return set;
  }
  if (const auto found = colours.find(field); found != colours.end()) {
    set.colour = found->second;
    if (words >> set.shade[0] >> set.shade[1] >> set.shade[2]) return set;
  }
  return std::nullopt;
}

std::optional<Command> fur_brush_of(std::istringstream& words) {
  using Of = render::FurStroke::Of;
  std::string of;
  render::FurStroke brush;
  words >> of >> brush.radius_mm;
  const auto kind = value_of(render::fur_brushes, of);
  if (!words || !kind || !(brush.radius_mm > 0.0)) return std::nullopt;
  brush.of = *kind;
  if (brush.of == Of::colour) {
    words >> brush.colour[0] >> brush.colour[1] >> brush.colour[2];
  } else if (brush.of != Of::comb) {
    words >> brush.amount;
  }
  return words ? std::optional<Command>(brush) : std::nullopt;
}

std::optional<Command> mouse_of(std::istringstream& words) {
  const std::array<const char*, 3> buttons{"left", "right", "middle"};
  std::string button;
  Mouse mouse;
  words >> button >> mouse.from.x() >> mouse.from.y() >> mouse.to.x() >> mouse.to.y();
  const auto found = std::find(buttons.begin(), buttons.end(), button);
  mouse.button = static_cast<int>(found - buttons.begin());
  return words && found != buttons.end() ? std::optional<Command>(mouse) : std::nullopt;
}

std::optional<Command> light_of(const std::string& name, std::istringstream& words) {
  using What = SetLight::What;
  SetLight set;
  if (name == "brightness") {
    set.what = What::brightness;
    words >> set.colour[0] >> set.colour[1] >> set.colour[2];
    return words && set.colour.minCoeff() >= 0.0 ? std::optional<Command>(set) : std::nullopt;
  }
  set.what = name == "turn" ? What::turn_deg : What::distance_mm;
  if (!(words >> set.value)) return std::nullopt;
  const bool possible = set.what == What::turn_deg ? std::abs(set.value) <= 360.0 : set.value > 0.0;
  return possible ? std::optional<Command>(set) : std::nullopt;
}

/// Recipes are named relative to `folder`, the script's.
std::optional<Command> command_of(const std::string& name, std::istringstream& words,
                                  const std::filesystem::path& folder) {
  static const std::map<std::string, Asked> of_edits{{"keep", Asked::keep},
                                                     {"cancel", Asked::cancel},
                                                     {"undo", Asked::undo},
                                                     {"redo", Asked::redo},
                                                     {"save", Asked::save}};
  if (const auto asked = of_edits.find(name); asked != of_edits.end()) return asked->second;
  if (name == "lamp") {
    Lamp lamp;
    if (words >> lamp.number && lamp.number >= 1) return lamp;
  } else if (name == "light") {
    TurnLight turn;
    if (words >> turn.azimuth_deg >> turn.elevation_deg) return turn;
  } else if (name == "turn" || name == "distance" || name == "brightness") {
    return light_of(name, words);
  } else if (name == "model") {
    ChooseModel choice;
    if (words >> choice.name) return choice;
  } else if (name == "orbit") {
    Orbit orbit;
    if (words >> orbit.right_deg >> orbit.up_deg) return orbit;
  } else if (name == "exposure") {
    Exposure exposure;
    if (words >> exposure.factor && exposure.factor > 0.0) return exposure;
  } else if (name == "panel") {
    std::string state;
    words >> state;
    if (state == "on") return Panel::on;
    if (state == "off") return Panel::off;
  } else if (name == "trace") {
    std::string state;
    words >> state;
    if (state == "on") return Trace::on;
    if (state == "off") return Trace::off;
  } else if (name == "compare") {
    std::string with;
    words >> with;
    if (with == "unedited") return Compared::unedited;
    if (with == "now") return Compared::kept;
    if (with == "off") return Compared::nothing;
  } else if (name == "screenshot") {
    Screenshot shot;
    if (words >> shot.name && is_plain_name(shot.name)) return shot;
  } else if (name == "brush") {
    return brush_of(words);
  } else if (name == "paint") {
    Paint paint;
    for (double value = 0.0; words >> value;) paint.points.push_back(value);
    if (words.eof() && !paint.points.empty() && paint.points.size() % 2 == 0) {
      words.clear();
      return paint;
    }
  } else if (name == "channel") {
    const std::array<const char*, 4> known{"all", "R", "G", "B"};
    std::string shown;
    words >> shown;
    const auto found = std::find(known.begin(), known.end(), shown);
    if (found != known.end()) return Channel{static_cast<int>(found - known.begin())};
  } else if (name == "preview") {
    std::string recipe;
    if (!(words >> recipe)) return std::nullopt;
    const render::Recipe read = render::read_recipe(folder / recipe);
    if (read.edits.size() == 1) return Preview{read.edits.front()};
  } else if (name == "photograph") {
    ShowPhotograph show;
    if (words >> show.number && show.number >= 0) return show;
  } else if (name == "slice") {
    ShowSlice show;
    char axis = '?';
    if (words >> show.volume >> axis >> show.index && axis >= 'x' && axis <= 'z') {
      show.axis = axis - 'x';
      return show;
    }
  } else if (name == "deform") {
    return deform_of(words, folder);
  } else if (name == "drag") {
    Drag drag;
    std::string kind;
    words >> kind >> drag.from.x() >> drag.from.y() >> drag.to.x() >> drag.to.y();
    drag.kind = kind == "dent" ? render::DeformKind::dent : render::DeformKind::pull;
    if (words >> drag.radius_mm && drag.radius_mm > 0.0 && (kind == "pull" || kind == "dent")) {
      return drag;
    }
  } else if (name == "fur") {
    return fur_of(words);
  } else if (name == "fur_brush") {
    return fur_brush_of(words);
  } else if (name == "mouse") {
    return mouse_of(words);
  } else if (name == "tool") {
    static const std::map<std::string, Tool> tools{
        {"orbit", Tool::orbit}, {"brush", Tool::brush}, {"shape", Tool::shape}, {"fur", Tool::fur}};
    std::string held;
    words >> held;
    if (const auto found = tools.find(held); found != tools.end()) return found->second;
  } else if (name == "comb") {
    CombFur comb;
    words >> comb.from.x() >> comb.from.y() >> comb.to.x() >> comb.to.y() >> comb.radius_mm;
    if (words && comb.radius_mm > 0.0) return comb;
  } else if (name == "links") {
    std::string how;
    words >> how;
    if (how == "kept") return Links::kept;
    if (how == "anew") return Links::anew;
  } else if (name == "quit") {
    return Quit{};
  }
  return std::nullopt;
}

}  // namespace

std::vector<Command> read(const std::filesystem::path& file) {
  std::istringstream text = io::text_reader(io::read_text(file));
  std::vector<Command> commands;
  std::string line, rest;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words = io::text_reader(line.substr(0, line.find('#')));
    std::string name;
    if (!(words >> name)) continue;
    const std::optional<Command> command = command_of(name, words, file.parent_path());
    if (!command || words >> rest) {
      throw InputError(
          file.string() + ": line " + std::to_string(number) + ": '" + shown_name(line) +
          "' is no command of a script, or lacks a value; docs/howto/view.md lists them");
    }
    // Refused before the first picture is computed.
    if (const auto* shot = std::get_if<Screenshot>(&*command)) {
      const std::string ending = std::filesystem::path(shot->name).extension();
      if (ending != ".png" && ending != ".tif" && ending != ".tiff") {
        throw InputError(file.string() + ": line " + std::to_string(number) + ": '" + shot->name +
                         "' names no picture; end it in .png, .tif or .tiff");
      }
    }
    if (const auto* brush = std::get_if<Brush>(&*command)) {
      try {
        require_valid(brush->edit(render::WholeSelection{}));
      } catch (const InputError& error) {
        throw InputError(file.string() + ": line " + std::to_string(number) + ": " + error.what());
      }
    }
    commands.push_back(*command);
  }
  return commands;
}

}  // namespace kappamu::app::script
