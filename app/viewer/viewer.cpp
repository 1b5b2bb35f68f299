#include "app/viewer/viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "app/viewer/drawing/shown.h"
#include "app/viewer/editing.h"
#include "app/viewer/fur/fur_hand.h"
#include "app/viewer/hand/mouse.h"
#include "app/viewer/hand/strokes.h"
#include "app/viewer/interrupt.h"
#include "app/viewer/opening/frame.h"
#include "app/viewer/opening/opening.h"
#include "app/viewer/overlay.h"
#include "app/viewer/panels.h"
#include "app/viewer/script/script_player.h"
#include "app/viewer/shaping.h"
#include "app/viewer/view_state.h"
#include "app/viewer/view_times.h"
#include "core/error.h"
#include "core/processor_time.h"
#include "io/image/image_file.h"

namespace kappamu::app {

namespace {

/// Before it looks whether Ctrl-C was pressed, and while work goes on [s].
constexpr double longest_wait_s = 0.5, label_period_s = 0.1, playing_wait_s = 0.01,
                 longest_script_wait_s = 0.001;
/// A view is traced once it has stood still for as long [s].
constexpr double steady_s = 0.25;

class Viewer {
 public:
  /// Keeps references to all but the options.
  Viewer(const render::Scene& scene, const ViewerOptions& options, Window& window,
         render::LiveScene& live, ViewTimes& times)
      : scene_(scene),
        options_(options),
        player_(options),
        live_(live),
        times_(times),
        editing_(scene, live.world(), options, [this] { edited(); }),
        shaping_(live.world(), editing_.painter()),
        state_(first_state(scene, ViewState::of(scene, live.world()), options, window.scale())),
        exposure_given_(scene.film.exposure.has_value()),
        window_(window),
        shown_(scene, live, [] { glfwPostEmptyEvent(); }),
        samples_(scene.film.samples) {
    if (editing_.painter().is_open()) state_.edits = options.edits->string();
    if (exposure_given_) state_.exposure = *scene.film.exposure;
    if (shown_.fur().any()) state_.traced = false;  // traced pictures have no fur
    edited();
  }

  ViewerTimes run() {
    const InterruptWatch interrupt;
    draw_frame();
    while (!done_) {
      if (interrupt.happened()) {
        interrupted_ = true;
        editing_.interrupted();
        break;
      }
      if (options_.script) {
        play();
        continue;
      }
      if (glfwWindowShouldClose(window_.handle()) == GLFW_TRUE && !closing_) {
        editing_.keep_lights(state_.lights);
        if (!editing_.painter().unsaved()) break;
        closing_ = true;
      }
      // Drawing takes from diffusion what it needs of the processor: only where the picture
      // changes.
      follow_view();
      const bool still = !working() && looked_at_ && !roughly_drawn_;
      const bool changed = window_.wait_for_events(state_.playing ? playing_wait_s
                                                   : still        ? longest_wait_s
                                                                  : label_period_s);
      const bool worked = std::exchange(worked_, working());
      if (take_answer() || shown_.take_picture() || beside_.update() || shown_.update_fur() ||
          worked != worked_ || (roughly_drawn_ && !moving())) {
        window_.draw_again();
      }
      if (state_.playing && !shown_.waiting()) turn_on();
      if (changed || (working() && since_drawn_.seconds() > label_period_s)) draw_frame();
    }
    ViewerTimes times = times_.result();
    if (shown_.answer() != nullptr) times.last = *shown_.answer();
    times.screenshots = screenshots_;
    times.saved = editing_.saved();
    times.warnings = editing_.warnings();
    times.interrupted = interrupted_;
    times.opened = opened_;
    times.models = render::live_models(live_.world());
    return times;
  }

 private:
  void ask(const std::string& model = "") {
    if (!model.empty()) chosen_ = model;
    times_.asked();
    since_asked_ = {};
    shown_.ask({state_.lights, editing_.painter().media(), chosen_, shaping_.question()});
  }

  /// The objects, or the lights, are others by an edit.
  void edited() {
    if (editing_.painter().take_lights()) {
      state_.lights = editing_.painter().lights();
      beside_.light(state_.lights);
    }
    shown_.fur().follow([this](std::size_t object) { return editing_.painter().fur(object); });
    ask();
  }

  /// Lights, objects or the view.
  bool moving() const {
    return since_asked_.seconds() < steady_s || (!options_.script && stood_.seconds() < steady_s);
  }

  bool waiting() const { return shown_.waiting() || beside_.waiting(); }
  bool improving() const { return waiting() || shown_.improving() || beside_.improving(); }
  bool working() const { return improving() || shown_.making_fur() || beside_.making_fur(); }

  void look(const std::optional<render::PictureView>& view) {
    shown_.look(view);
    beside_.look(view);
  }

  void compare(Compared with) {
    beside_.show(nullptr);
    state_.compared = with;
    if (with == Compared::nothing) return;
    try {
      beside_.show(compared_with(
          with, scene_, options_.another(),
          {state_.lights, editing_.painter().media(), chosen_, shaping_.question()},
          [this](std::size_t object) { return editing_.painter().fur(object); },
          [] { glfwPostEmptyEvent(); }));
    } catch (const InputError& error) {  // a file of the scene is there no more
      if (options_.script) throw;
      note_ = error.what();
      state_.compared = Compared::nothing;
    }
  }

  /// Of a person or a script, noted in the state.
  void follow_requests() {
    if (std::exchange(state_.lights_changed, false)) {
      ask();
      beside_.light(state_.lights);
    }
    if (shaping_.take_change()) ask();
    // A turn is an edit once the hand lets go of the light.
    if (!state_.playing && !ImGui::IsAnyMouseDown() && !ImGui::IsAnyItemActive()) {
      editing_.keep_lights(state_.lights);
    }
    if (state_.asked_to_compare) compare(*std::exchange(state_.asked_to_compare, std::nullopt));
  }

  render::PictureView view() const { return state_.view(density_, samples_); }

  /// A view is traced where it stays; in a script where it is written.
  void follow_view() {
    if (options_.script) {
      lay_out(scene_, options_, options_.width, options_.height, state_);
      look(player_.takes_picture() && state_.traced ? std::optional(view()) : std::nullopt);
      return;
    }
    if (const render::PictureView now = view(); !(now == wanted_)) {
      wanted_ = now;
      stood_ = {};
    }
    looked_at_ = stood_.seconds() > steady_s;
    look(looked_at_ && state_.traced ? std::optional(wanted_) : std::nullopt);
  }

  /// Whether there is another picture to draw.
  bool take_answer() {
    if (!shown_.waiting() && !shown_.refining()) times_.settled();
    if (!shown_.take_answer()) return false;
    const render::LiveAnswer& answer = *shown_.answer();
    if (options_.script) {
      for (const auto& [what, refused] :
           {std::pair(": model: ", answer.refused), {": ", answer.shape_refused}}) {
        if (!refused.empty()) throw InputError(options_.script->string() + what + refused);
      }
    }
    if (!answer.refused.empty()) chosen_.clear();
    state_.model = answer.model;
    shaping_.take(answer);
    if (!exposure_given_) {
      state_.exposure = render::usual_exposure(live_.world(), answer, state_.camera.position_mm);
      exposure_given_ = true;
    }
    times_.answered(answer, !shown_.waiting());
    return true;
  }

  /// The light in hand goes on turning round: the next answer is worked on while the last is drawn.
  void turn_on() {
    state_.turn_on(played_.seconds());
    played_ = {};
    times_.begin_event();
    follow_requests();
  }

  void draw_frame() {
    const Stopwatch watch;
    times_.begin_event();
    shown_.update_fur();
    set_title();
    since_drawn_ = watch;
    const FrameSize size = frame_size(window_, options_);
    if (size.empty()) return;
    lay_out(scene_, options_, size.across, size.high, state_);
    density_ = size.density();
    const Viewport at = size.viewport(state_);
    Display& display = shown_.display();
    roughly_drawn_ = moving() && !writing_;
    const PictureDrawn now{
        view(),           at, size, state_.exposure, state_.channel, state_.traced, roughly_drawn_,
        display.version()};
    // Fur and another state change by themselves.
    if (!(drawn_ == now) || shown_.fur().any() || beside_.shown()) {
      display.begin(size.width, size.height, roughly_drawn_ ? Edges::plain : Edges::smooth);
      shown_.draw(state_, view(), at);
      beside_.draw(state_, view(), at, shown_);
      display.end();
      drawn_ = beside_.shown() ? std::nullopt : std::optional(now);
    }
    display.draw_over();
    draw_over();
    if (options_.script) {
      display.finish();
    } else {
      display.show(size.width, size.height);
      glfwSwapBuffers(window_.handle());
    }
    times_.drawn(watch.milliseconds());
  }

  void draw_over() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    if (pointed_) point(*pointed_);
    ImGui::NewFrame();
    const std::string model = state_.model;
    panels_.draw(beside_, times_.last_frame_ms(), note_, state_);
    if (state_.keys_shown) draw_keys(state_);
    mouse_.follow(state_);
    const std::vector<PointerEvent> events = window_.take_pointer_events();
    strokes_.follow(events, mouse_, state_);
    fur_hand_.follow(events, mouse_, state_);
    follow_keys();
    for (const std::string& file : window_.take_dropped()) open(file);
    if (closing_) close(draw_closing_question());
    if (model != state_.model) ask(state_.model);
    follow_requests();
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }

  /// A script's mouse in place of a person's.
  void point(const Pointed& by) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {static_cast<float>(by.at.x()), static_cast<float>(by.at.y())};
    io.MouseDown[by.button] = by.held;
    const bool left = by.button == ImGuiMouseButton_Left;
    window_.point({by.at.x(), by.at.y(), left && by.held, left && by.pressed});
  }

  void follow_keys() {
    for (const KeyEvent& event : window_.take_key_events()) {
      if (ImGui::GetIO().WantTextInput || closing_) continue;
      editing_.obey(asked_by(event), state_.edits);
      follow_view_key(event, scene_.camera, state_);
    }
  }

  /// Instead of what is looked at.
  void open(const std::string& file) {
    note_.clear();
    try {
      options_.check(file);
    } catch (const InputError& error) {
      note_ = error.what();
      return;
    }
    opened_ = file;
    glfwSetWindowShouldClose(window_.handle(), GLFW_TRUE);
  }

  void close(Closing closing) {
    if (closing == Closing::undecided) return;
    closing_ = false;
    glfwSetWindowShouldClose(window_.handle(), GLFW_FALSE);
    done_ = editing_.close(closing, state_.edits);
    if (!done_) opened_.reset();
  }

  void set_title() {
    const std::string title =
        options_.title + (editing_.painter().unsaved() ? " * not saved" : "") + " - kappamu";
    if (title != title_) glfwSetWindowTitle(window_.handle(), title.c_str());
    title_ = title;
  }

  /// One command of the script, once what was asked is answered, for a screenshot exactly enough.
  void play() {
    follow_view();
    if (player_.takes_picture() ? improving() : waiting()) {
      if (take_answer()) {
        // As for a hand that goes on: the next answer is worked on while this one is drawn.
        if (player_.turns_light() && !waiting()) obey_script();
        draw_frame();
      }
      shown_.take_picture();
      beside_.update();
      window_.wait_for_events(longest_script_wait_s);
      return;
    }
    done_ = player_.finished();
    if (!done_) obey_script();
  }

  void obey_script() {
    Stage stage{state_,
                editing_,
                shaping_,
                shown_.fur(),
                panels_.photograph_count(),
                [this](const std::string& model) { ask(model); },
                [this](const std::filesystem::path& file) { write_screenshot(file); },
                [this](const Pointed& by) {
                  pointed_ = by;
                  draw_frame();
                  pointed_.reset();
                }};
    times_.begin_event();
    player_.play(stage);
    follow_requests();
  }

  void write_screenshot(const std::filesystem::path& file) {
    // Two frames: a panel that has just appeared takes its size in the first.
    shown_.finish_fur();
    beside_.finish_fur();
    writing_ = true;
    draw_frame();
    draw_frame();
    writing_ = false;
    io::write_image(file, shown_.display().picture());
    screenshots_.push_back(file.string());
  }

  const render::Scene& scene_;
  ViewerOptions options_;
  ScriptPlayer player_;
  std::optional<Pointed> pointed_;
  render::LiveScene& live_;
  ViewTimes& times_;
  Editing editing_;
  Shaping shaping_;
  ViewState state_;
  bool exposure_given_ = false, done_ = false;
  bool worked_ = false;   ///< at the last look
  bool closing_ = false;  ///< it is asked what becomes of unsaved edits
  Window& window_;
  Shown shown_;
  FurHand fur_hand_{shown_.fur(), editing_};
  const int samples_;                             ///< rays a pixel of traced pictures
  render::PictureView wanted_;                    ///< that the window last showed
  Stopwatch stood_;                               ///< since it is that
  bool looked_at_ = false;                        ///< for long enough to be traced
  float density_ = 1.0F;                          ///< pixels per unit of screen coordinates
  Stopwatch since_drawn_, since_asked_, played_;  ///< the light in hand turned
  bool roughly_drawn_ = false;                    ///< with one sample a pixel
  std::optional<PictureDrawn> drawn_;
  bool writing_ = false;  ///< the picture to a file
  std::vector<std::string> screenshots_;
  bool interrupted_ = false;
  std::optional<std::string> opened_;
  std::string title_, chosen_, note_;
  Mouse mouse_;
  Strokes strokes_{editing_, shaping_};
  Panels panels_{live_, options_, editing_, shaping_, shown_, scene_.camera};
  Beside beside_;
};

}  // namespace

ViewerTimes view(const render::Scene& scene, const LiveMaker& make, const ViewerOptions& options) {
  ViewTimes times(options.started);
  const Opened opened = open_window(scene, make, options, times);
  if (!opened.live) return times.result();
  return Viewer(scene, options, *opened.window, *opened.live, times).run();
}

}  // namespace kappamu::app
