#include "app/viewer/script/script_player.h"

#include <algorithm>

#include "core/error.h"
#include "pipeline/owned_files.h"

namespace kappamu::app {

ScriptPlayer::ScriptPlayer(const ViewerOptions& options) : options_(options) {
  if (!options.script) return;
  name_ = options.script->string();
  commands_ = script::read(*options.script);
  for (const script::Command& command : commands_) {
    const auto* shot = std::get_if<script::Screenshot>(&command);
    if (shot != nullptr) pipeline::require_absent(options.out / shot->name);
  }
}

bool ScriptPlayer::takes_picture() const {
  return !finished() && std::holds_alternative<script::Screenshot>(commands_[next_]);
}

bool ScriptPlayer::turns_light() const {
  return !finished() && std::holds_alternative<script::TurnLight>(commands_[next_]);
}

void ScriptPlayer::play(Stage& stage) {
  const script::Command& command = commands_[next_++];
  std::visit([&](const auto& what) { obey(what, stage); }, command);
}

void ScriptPlayer::obey(const script::Lamp& lamp, Stage& stage) const {
  const std::size_t lights = stage.state.lights.size();
  if (static_cast<std::size_t>(lamp.number) > lights) {
    throw InputError(name_ + ": the scene has " + std::to_string(lights) + " lights and no light " +
                     std::to_string(lamp.number));
  }
  stage.state.lamp = static_cast<std::size_t>(lamp.number - 1);
}

void ScriptPlayer::obey(const script::TurnLight& turn, Stage& stage) const {
  stage.state.turn_light({turn.azimuth_deg, turn.elevation_deg});
}

void ScriptPlayer::obey(const script::SetLight& set, Stage& stage) const {
  using What = script::SetLight::What;
  ViewState& state = stage.state;
  if (state.lights.empty()) throw InputError(name_ + ": the scene has no light");
  render::Light light = state.lights[state.lamp];
  const std::string kind = ": the light in hand is of the kind " + render::kind_of(light);
  if (set.what == What::brightness) {
    render::intensity_of(light) = set.colour;
  } else if (set.what == What::distance_mm) {
    if (!render::distance_of(light, state.centre))
      throw InputError(name_ + kind + ", which stands nowhere");
    light = render::at_distance(light, state.centre, set.value);
  } else {
    auto* environment = std::get_if<render::EnvironmentLight>(&light);
    if (environment == nullptr)
      throw InputError(name_ + kind + ", which has no turn; use light AZ EL");
    environment->turn_deg = set.value;
  }
  state.set_light(light);
}

void ScriptPlayer::obey(const script::ChooseModel& choice, Stage& stage) const {
  stage.choose_model(choice.name);
}

void ScriptPlayer::obey(const script::Orbit& orbit, Stage& stage) const {
  stage.state.orbit(orbit.right_deg, orbit.up_deg);
}

void ScriptPlayer::obey(const script::Exposure& exposure, Stage& stage) const {
  stage.state.exposure = exposure.factor;
}

void ScriptPlayer::obey(script::Panel panel, Stage& stage) const {
  stage.state.panel = panel == script::Panel::on;
}

void ScriptPlayer::obey(const script::Screenshot& shot, Stage& stage) const {
  stage.screenshot(options_.out / shot.name);
}

void ScriptPlayer::obey(const Brush& brush, Stage& stage) const {
  stage.state.brush = brush;
}

void ScriptPlayer::obey(const script::Paint& stroke, Stage& stage) const {
  const PictureArea& area = stage.state.area;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i + 1 < stroke.points.size(); i += 2) {
    points.push_back(area.in_picture(stroke.points[i], stroke.points[i + 1]));
  }
  stage.editing.stroke_through(stage.state.look(area.aspect()), points, stage.state.brush);
  if (stage.editing.end_stroke() == Painter::Stroked::none) {
    throw InputError(name_ + ": paint: no object lies under the stroke");
  }
}

void ScriptPlayer::obey(script::Channel channel, Stage& stage) const {
  stage.state.channel = channel.number;
}

void ScriptPlayer::obey(const script::Preview& asked, Stage& stage) const {
  stage.editing.preview(asked.edit);
}

void ScriptPlayer::obey(Asked asked, Stage& stage) const {
  stage.editing.obey(asked, stage.state.edits);
}

void ScriptPlayer::obey(const script::ShowPhotograph& show, Stage& stage) const {
  if (show.number > stage.photographs) {
    throw InputError(name_ + ": photograph: there are " + std::to_string(stage.photographs) +
                     " to show; a run with a fit has them");
  }
  stage.state.photograph = {show.number > 0, std::max(0, show.number - 1)};
}

void ScriptPlayer::obey(const script::ShowSlice& show, Stage& stage) const {
  Painter& painter = stage.editing.painter();
  const auto volumes = io::named_volumes(painter.edited(painter.in_hand()).history().volume());
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if (volumes[i].name == show.volume) {
      stage.state.slice = {true, i, show.axis, show.index};
      return;
    }
  }
  throw InputError(name_ + ": slice: there is no volume '" + show.volume + "'");
}

void ScriptPlayer::obey(script::Quit /*quit*/, Stage& /*stage*/) {
  next_ = commands_.size();
}

void ScriptPlayer::obey(const script::Deform& deform, Stage& stage) const {
  const auto& objects = stage.shaping.world().objects();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].name == deform.object) {
      stage.shaping.set(i, deform.deformations, deform.moving);
      return;
    }
  }
  throw InputError(name_ + ": deform: there is no object '" + deform.object + "'");
}

void ScriptPlayer::obey(const script::Drag& drag, Stage& stage) const {
  const PictureArea& area = stage.state.area;
  const render::LookAt look = stage.state.look(area.aspect());
  stage.shaping.brush.kind = drag.kind;
  stage.shaping.brush.radius_mm = drag.radius_mm;
  if (!stage.shaping.press(look, area.in_picture(drag.from.x(), drag.from.y()))) {
    throw InputError(name_ + ": drag: no object lies there");
  }
  stage.shaping.drag(look, area.in_picture(drag.to.x(), drag.to.y()));
  stage.shaping.release();
}

void ScriptPlayer::obey(const script::SetFur& set, Stage& stage) const {
  if (!stage.fur.any()) throw InputError(name_ + ": fur: no object of the scene has fur");
  for (std::size_t i = 0; i < stage.fur.coats(); ++i) {
    const std::size_t object = stage.fur.shown(i).object;
    const render::Fur before = stage.editing.painter().fur(object);
    render::Fur fur = before;
    if (set.field != nullptr) fur.*set.field = set.value;
    if (set.colour != nullptr) fur.*set.colour = set.shade;
    try {
      stage.fur.set(i, fur);
    } catch (const InputError& error) {
      throw InputError(name_ + ": " + error.what());
    }
    stage.editing.change_fur(object, render::change_between(before, fur));
  }
}

void ScriptPlayer::obey(const script::CombFur& comb, Stage& stage) const {
  const PictureArea& area = stage.state.area;
  stage.fur.finish();
  stage.fur.brush.radius_mm = comb.radius_mm;
  stage.fur.brush.of = render::FurStroke::Of::comb;
  if (!stage.fur.stroke(stage.state.look(area.aspect()),
                        area.in_picture(comb.from.x(), comb.from.y()),
                        area.in_picture(comb.to.x(), comb.to.y()))) {
    throw InputError(name_ + ": comb: no fur lies there");
  }
  for (const auto& [object, change] : stage.fur.end_stroke()) {
    stage.editing.change_fur(object, change);
  }
}

void ScriptPlayer::obey(const render::FurStroke& brush, Stage& stage) const {
  stage.fur.brush = brush;
}

void ScriptPlayer::obey(Tool tool, Stage& stage) const {
  stage.state.tool = tool;
}

void ScriptPlayer::obey(const script::Mouse& mouse, Stage& stage) const {
  stage.fur.finish();
  constexpr int steps = 8;
  const auto frame = [&](double share, bool held, bool pressed) {
    const Eigen::Vector2d at = mouse.from + share * (mouse.to - mouse.from);
    stage.point({at, mouse.button, held, pressed});
  };
  // A panel under the mouse is known after a frame, and answers to a release in the next.
  frame(0.0, false, false);
  frame(0.0, true, true);
  for (int i = 1; i <= steps; ++i) frame(static_cast<double>(i) / steps, true, false);
  frame(1.0, false, false);
  frame(1.0, false, false);
}

void ScriptPlayer::obey(script::Links links, Stage& stage) const {
  stage.shaping.renewal = links == script::Links::anew;
}

void ScriptPlayer::obey(Compared with, Stage& stage) const {
  stage.state.asked_to_compare = with;
}

void ScriptPlayer::obey(script::Trace trace, Stage& stage) const {
  stage.state.traced = trace == script::Trace::on;
}

}  // namespace kappamu::app
