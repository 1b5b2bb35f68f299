// Plays a script in place of a person.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/viewer/editing.h"
#include "app/viewer/fur/fur_model.h"
#include "app/viewer/script/script.h"
#include "app/viewer/shaping.h"
#include "app/viewer/view_state.h"
#include "app/viewer/viewer.h"

namespace kappamu::app {

/// Where a script has the mouse.
struct Pointed {
  Eigen::Vector2d at;  ///< [screen coordinates]
  int button = 0;      ///< as ImGui has it
  bool held = false, pressed = false;
};

/// What a script acts on.
struct Stage {
  ViewState& state;
  Editing& editing;
  Shaping& shaping;
  FurModel& fur;
  int photographs = 0;  ///< that can be shown
  std::function<void(const std::string&)> choose_model;
  std::function<void(const std::filesystem::path&)> screenshot;  ///< writes the picture
  std::function<void(const Pointed&)> point;                     ///< draws what follows from it
};

class ScriptPlayer {
 public:
  /// No script: nothing to play. Throws InputError naming the line that cannot be played, and where
  /// a screenshot would replace a file.
  explicit ScriptPlayer(const ViewerOptions& options);

  bool finished() const { return next_ == commands_.size(); }
  /// Whether the next command writes the picture.
  bool takes_picture() const;
  /// Whether the next command turns a light and no more.
  bool turns_light() const;
  /// The next command; throws InputError naming the script.
  void play(Stage& stage);

 private:
  void obey(const script::Lamp& lamp, Stage& stage) const;
  void obey(const script::TurnLight& turn, Stage& stage) const;
  void obey(const script::SetLight& set, Stage& stage) const;
  void obey(const script::ChooseModel& choice, Stage& stage) const;
  void obey(const script::Orbit& orbit, Stage& stage) const;
  void obey(const script::Exposure& exposure, Stage& stage) const;
  void obey(script::Panel panel, Stage& stage) const;
  void obey(const script::Screenshot& shot, Stage& stage) const;
  void obey(const Brush& brush, Stage& stage) const;
  void obey(const script::Paint& stroke, Stage& stage) const;
  void obey(script::Channel channel, Stage& stage) const;
  void obey(const script::Preview& asked, Stage& stage) const;
  void obey(Asked asked, Stage& stage) const;
  void obey(const script::Deform& deform, Stage& stage) const;
  void obey(const script::Drag& drag, Stage& stage) const;
  void obey(script::Links links, Stage& stage) const;
  void obey(script::Trace trace, Stage& stage) const;
  void obey(Compared with, Stage& stage) const;
  void obey(const render::FurStroke& brush, Stage& stage) const;
  void obey(Tool tool, Stage& stage) const;
  void obey(const script::Mouse& mouse, Stage& stage) const;
  void obey(const script::SetFur& set, Stage& stage) const;
  void obey(const script::CombFur& comb, Stage& stage) const;
  void obey(const script::ShowPhotograph& show, Stage& stage) const;
  void obey(const script::ShowSlice& show, Stage& stage) const;
  void obey(script::Quit quit, Stage& stage);

  ViewerOptions options_;
  std::string name_;
  std::vector<script::Command> commands_;
  std::size_t next_ = 0;
};

}  // namespace kappamu::app
