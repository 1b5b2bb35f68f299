#include "app/viewer/viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <utility>

#include "app/viewer/answers.h"
#include "app/viewer/comparison.h"
#include "app/viewer/drawing/display.h"
#include "app/viewer/editing.h"
#include "app/viewer/fur/fur_group.h"
#include "app/viewer/fur/fur_hand.h"
#include "app/viewer/hand/mouse.h"
#include "app/viewer/hand/strokes.h"
#include "app/viewer/interrupt.h"
#include "app/viewer/overlay.h"
#include "app/viewer/panel.h"
#include "app/viewer/panel/photographs.h"
#include "app/viewer/panel/slice_window.h"
#include "app/viewer/script/script_player.h"
#include "app/viewer/shaping.h"
#include "app/viewer/view_state.h"
#include "app/viewer/window.h"
#include "core/error.h"
#include "core/numbers/median.h"
#include "core/processor_time.h"
#include "io/image/image_file.h"

namespace kappamu::app {

namespace {

double median(std::vector<double> values) {
  return values.empty() ? 0.0 : upper_median(std::move(values));
}

/// How long the window waits for a person or an answer before it looks whether Ctrl-C was pressed,
/// and while work goes on, whose progress it shows [s].
constexpr double longest_wait_s = 0.5, label_period_s = 0.1, playing_wait_s = 0.01,
                 longest_script_wait_s = 0.001;
/// A view is traced once it has stood still for as long [s].
constexpr double steady_s = 0.25;
/// Of a light that turns round by itself [degrees a second].
constexpr double turning_speed = 30.0;
/// A picture narrower than this has the panel over it, and no line of state [px].
constexpr int least_docked_px = 720;

class Viewer {
 public:
  Viewer(const render::Scene& scene, render::LiveScene& live, const ViewerOptions& options)
      : options_(options),
        player_(options),
        live_(live),
        editing_(scene, live.world(), options, [this] { ask(); }),
        shaping_(live.world(), editing_.painter()),
        state_(ViewState::of(scene, live.world())),
        first_camera_(state_.camera),
        exposure_given_(scene.film.exposure.has_value()),
        window_(options.width, options.height,
                options.script ? WindowKind::hidden : WindowKind::shown),
        display_(live.world()),
        fur_(scene, live.world()),
        samples_(scene.film.samples),
        film_aspect_(static_cast<double>(scene.film.width) / scene.film.height),
        answers_(live, [] { glfwPostEmptyEvent(); }) {
    if (options.run) photographs_.emplace(*options.run);
    if (editing_.painter().is_open()) state_.edits = options.edits->string();
    if (exposure_given_) state_.exposure = *scene.film.exposure;
    state_.scale = window_.scale();
    // What the film's width shows is shown, though the panel takes of it.
    lay_out(options_.width, options_.height);
    state_.zoom(std::max(1.0, film_aspect_ / state_.area.aspect()));
    groups_.push_back(light_group());
    groups_.push_back(view_group(photograph_count() > 0));
    groups_.push_back(shape_group(shaping_));
    groups_.push_back(edit_group(editing_.painter()));
    groups_.push_back(material_group(editing_.painter()));
    groups_.push_back(model_group(render::live_models(live.world())));
    if (fur_.any()) {
      fur_canvas_.emplace();
      display_.show_fur(*fur_canvas_, fur_);
      groups_.push_back(fur_group(fur_, *fur_canvas_));
      state_.traced = state_.can_compare = false;  // traced pictures have no fur
    }
    ask();
  }

  ViewerTimes run() {
    const InterruptWatch interrupt;
    draw_frame();
    while (!done_) {
      if (interrupt.happened()) {
        times_.interrupted = true;
        editing_.interrupted();
        break;
      }
      if (options_.script) {
        play();
        continue;
      }
      if (glfwWindowShouldClose(window_.handle()) == GLFW_TRUE && !closing_) {
        if (!editing_.painter().unsaved()) break;
        closing_ = true;
      }
      // Drawing takes from diffusion what it needs of the processor: only where the picture
      // changes.
      follow_view();
      const bool changed = window_.wait_for_events(state_.playing             ? playing_wait_s
                                                   : working() || !looked_at_ ? label_period_s
                                                                              : longest_wait_s);
      if (state_.playing && !answers_.waiting()) turn_on();
      const bool worked = std::exchange(worked_, working());
      if (take_answer() || take_picture() || (comparison_ && comparison_->update()) ||
          update_fur() || worked != worked_) {
        window_.draw_again();
      }
      if (changed || (working() && since_drawn_.seconds() > label_period_s)) draw_frame();
    }
    times_.light_ms = median(light_ms_);
    times_.model_ms = median(model_ms_);
    times_.frame_ms = median(frame_ms_);
    for (const auto& [mode, milliseconds] : shape_ms_) times_.shape_ms[mode] = median(milliseconds);
    if (answer_) times_.last = *std::exchange(answer_, std::nullopt);
    times_.saved = editing_.saved();
    times_.warnings = editing_.warnings();
    return times_;
  }

 private:
  int photograph_count() const { return photographs_ ? photographs_->count() : 0; }

  void ask(const std::string& model = "") {
    if (!model.empty()) chosen_ = model;
    display_.drop_traced();
    fur_.set_lights(state_.lights);
    answers_.ask({state_.lights, editing_.painter().media(), chosen_, shaping_.question()});
  }

  bool waiting() const { return answers_.waiting() || (comparison_ && comparison_->waiting()); }
  bool improving() const {
    return answers_.refining() || answers_.tracing() || (comparison_ && comparison_->improving());
  }
  bool working() const { return fur_.making() || waiting() || improving(); }

  void look(const std::optional<render::PictureView>& view) {
    answers_.look(view);
    if (comparison_) comparison_->look(view);
  }

  void lights_changed() {
    ask();
    if (comparison_) comparison_->light(state_.lights);
  }

  void compare(Compared with) {
    comparison_.reset();
    state_.compared = with;
    if (with == Compared::nothing) return;
    render::LiveQuestion held;
    held.lights = state_.lights;
    if (with == Compared::kept) {
      held.media = editing_.painter().media();
      held.model = chosen_;
      held.shape = shaping_.question();
      held.shape.moving = false;
    }
    try {
      comparison_ = std::make_unique<Comparison>(options_.another(), std::move(held),
                                                 with == Compared::kept ? "as it was" : "unedited",
                                                 [] { glfwPostEmptyEvent(); });
    } catch (const InputError& error) {  // a file of the scene is there no more
      if (options_.script) throw;
      note_ = error.what();
      state_.compared = Compared::nothing;
    }
  }

  /// Of a person or a script, noted in the state.
  void follow_requests() {
    if (std::exchange(state_.lights_changed, false)) lights_changed();
    if (shaping_.take_change()) ask();
    if (state_.asked_to_compare) compare(*std::exchange(state_.asked_to_compare, std::nullopt));
  }

  /// The picture that the window's part for it shows, as it would be traced.
  render::PictureView view() const {
    render::PictureView view;
    view.camera = state_.camera;
    view.width = std::max(1, static_cast<int>(density_ * state_.area.width));
    view.height = std::max(1, static_cast<int>(density_ * state_.area.height));
    view.samples = samples_;
    return view;
  }

  /// A view is traced where it stays; in a script where it is written.
  void follow_view() {
    if (options_.script) {
      lay_out(options_.width, options_.height);
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

  bool take_picture() {
    const std::optional<Answers::Traced> traced = answers_.take_picture();
    if (traced) display_.take(*traced);
    return traced.has_value();
  }

  /// With what fur leaves of the skin's light, now.
  void show_answer() {
    if (!fur_.any()) return display_.take(*answer_, state_.lights);
    render::LiveAnswer under_fur = *answer_;
    fur_.shade(under_fur);
    display_.take(under_fur, state_.lights);
  }

  bool update_fur() {
    const bool changed = fur_.update();
    if (changed && answer_) show_answer();
    return changed;
  }

  /// Whether there is another picture to draw.
  bool take_answer() {
    if (times_.first_light_s > 0.0 && times_.settled_s == 0.0 && !answers_.waiting() &&
        !answers_.refining()) {
      times_.settled_s = options_.started.seconds();
    }
    std::optional<render::LiveAnswer> answer = answers_.take();
    if (!answer) return false;
    answer_ = std::move(answer);
    if (options_.script && !answer_->refused.empty()) {
      throw InputError(options_.script->string() + ": model: " + answer_->refused);
    }
    if (!answer_->refused.empty()) chosen_.clear();
    state_.model = answer_->model;
    if (times_.first_light_s == 0.0) times_.first_light_s = options_.started.seconds();
    if (!answer_->moved.empty()) {
      live_.show(*answer_);
      fur_.moved();
    }
    shaping_.take(*answer_);
    if (options_.script && !answer_->shape_refused.empty()) {
      throw InputError(options_.script->string() + ": " + answer_->shape_refused);
    }
    show_answer();
    if (!exposure_given_) {
      state_.exposure = render::usual_exposure(live_.world(), *answer_, state_.camera.position_mm);
      exposure_given_ = true;
    }
    ++times_.answers;
    light_ms_.push_back(answer_->light_ms);
    model_ms_.push_back(answer_->model_ms);
    if (answer_->mode != "static") shape_ms_[answer_->mode].push_back(answer_->total_ms());
    return true;
  }

  void lay_out(int width, int height) {
    state_.docked = !options_.script || width >= least_docked_px;
    state_.lay_out(width, height, film_aspect_);
  }

  /// The light in hand goes on turning round.
  void turn_on() {
    constexpr double longest_step_s = 0.2;
    const double turn = turning_speed * std::min(longest_step_s, played_.seconds());
    played_ = {};
    const Eigen::Vector3d towards = render::towards(state_.lights[state_.lamp], state_.centre);
    state_.drag_light(Eigen::AngleAxisd(turn * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()) *
                      towards);
    window_.draw_again();
  }

  void draw_frame() {
    const Stopwatch watch;
    update_fur();
    set_title();
    since_drawn_ = watch;
    int width = options_.width, height = options_.height, across = width, high = height;
    if (!options_.script) {
      glfwGetFramebufferSize(window_.handle(), &width, &height);
      glfwGetWindowSize(window_.handle(), &across, &high);
    }
    if (width < 1 || height < 1 || across < 1 || high < 1) return;
    lay_out(across, high);
    density_ = static_cast<float>(width) / static_cast<float>(across);
    const PictureArea& area = state_.area;
    Viewport at{static_cast<int>(density_ * area.x),
                height - static_cast<int>(density_ * (area.y + area.height)), view().width,
                view().height};
    display_.begin(width, height);
    display_.draw(state_, view(), answer_.has_value(), at);
    if (comparison_) {
      at.x -= at.width;
      comparison_->draw(state_, view(), at);
    }
    display_.end();
    draw_over();
    if (!options_.script) {
      display_.show(width, height);
      glfwSwapBuffers(window_.handle());
    }
    if (times_.frames++ == 0) times_.first_picture_s = options_.started.seconds();
    last_frame_ms_ = watch.milliseconds();
    frame_ms_.push_back(last_frame_ms_);
  }

  void draw_over() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    if (pointed_) point(*pointed_);
    ImGui::NewFrame();
    const std::string model = state_.model;
    draw_panels();
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

  void draw_panels() {
    if (state_.docked && state_.marks_shown) {
      draw_marks(state_);
      if (comparison_) draw_names(state_, comparison_->label());
    }
    if (state_.docked) {
      draw_status(state_, answer_ ? &*answer_ : nullptr, live_.tolerance(), answers_.work_now());
    }
    if (!state_.panel) return;
    const PanelNumbers numbers{answer_ ? &*answer_ : nullptr, last_frame_ms_,
                               note_.empty() ? editing_.note() : note_};
    editing_.obey_panel(draw_panel(groups_, numbers, state_), state_);
    if (state_.slice.shown) {
      Painter& painter = editing_.painter();
      const std::size_t edited = painter.in_hand();
      slices_.draw(painter.edited(edited).history().volume(), painter.axes(edited), first_camera_,
                   state_.scale, state_.slice);
    }
    if (state_.photograph.shown) photographs_->draw(state_.scale, state_.photograph);
  }

  void follow_keys() {
    for (const KeyEvent& event : window_.take_key_events()) {
      if (ImGui::GetIO().WantTextInput || closing_) continue;
      if (event.control) {
        if (event.key == GLFW_KEY_Z) {
          editing_.obey(event.shift ? Asked::redo : Asked::undo, state_.edits);
        }
        if (event.key == GLFW_KEY_Y) editing_.obey(Asked::redo, state_.edits);
        if (event.key == GLFW_KEY_S) editing_.obey(Asked::save, state_.edits);
      }
      follow_view_key(event, first_camera_, state_);
    }
  }

  /// Instead of what is looked at, where it can be read.
  void open(const std::string& file) {
    note_.clear();
    try {
      options_.check(file);
    } catch (const InputError& error) {
      note_ = error.what();
      return;
    }
    times_.opened = file;
    glfwSetWindowShouldClose(window_.handle(), GLFW_TRUE);
  }

  void close(Closing closing) {
    if (closing == Closing::undecided) return;
    closing_ = false;
    glfwSetWindowShouldClose(window_.handle(), GLFW_FALSE);
    done_ = editing_.close(closing, state_.edits);
    if (!done_) times_.opened.reset();
  }

  void set_title() {
    const std::string title =
        options_.title + (editing_.painter().unsaved() ? " * not saved" : "") + " - kappamu";
    if (title != title_) glfwSetWindowTitle(window_.handle(), title.c_str());
    title_ = title;
  }

  /// One command of the script, once the picture is of the light as it stands; for a screenshot,
  /// once it is as exact as asked.
  void play() {
    follow_view();
    if (waiting() || (player_.takes_picture() && improving())) {
      if (take_answer()) draw_frame();
      take_picture();
      if (comparison_) comparison_->update();
      window_.wait_for_events(longest_script_wait_s);
      return;
    }
    done_ = player_.finished();
    if (done_) return;
    Stage stage{state_,
                editing_,
                shaping_,
                fur_,
                photograph_count(),
                [this](const std::string& model) { ask(model); },
                [this](const std::filesystem::path& file) { write_screenshot(file); },
                [this](const Pointed& by) {
                  pointed_ = by;
                  draw_frame();
                  pointed_.reset();
                }};
    player_.play(stage);
    follow_requests();
  }

  void write_screenshot(const std::filesystem::path& file) {
    // Two frames: a panel that has just appeared takes its size in the first.
    fur_.finish();
    if (fur_.any() && answer_) show_answer();
    draw_frame();
    draw_frame();
    io::write_image(file, display_.picture());
    times_.screenshots.push_back(file.string());
  }

  ViewerOptions options_;
  ScriptPlayer player_;
  std::optional<Pointed> pointed_;
  render::LiveScene& live_;
  Editing editing_;
  Shaping shaping_;
  ViewState state_;
  const render::Camera first_camera_;  ///< that slices stand upright in
  bool exposure_given_ = false, done_ = false;
  bool worked_ = false;   ///< at the last look
  bool closing_ = false;  ///< it is asked what becomes of unsaved edits
  Window window_;
  PanelGroups groups_;
  Display display_;
  FurModel fur_;
  FurHand fur_hand_{fur_};
  std::optional<FurCanvas> fur_canvas_;
  const int samples_;  ///< rays a pixel of traced pictures
  const double film_aspect_;
  render::PictureView wanted_;                ///< that the window last showed
  Stopwatch stood_;                           ///< since it is that
  bool looked_at_ = false;                    ///< for long enough to be traced
  float density_ = 1.0F;                      ///< pixels per unit of screen coordinates
  std::optional<render::LiveAnswer> answer_;  ///< that the picture shows
  Stopwatch since_drawn_;
  double last_frame_ms_ = 0.0;
  std::vector<double> light_ms_, model_ms_, frame_ms_;
  std::map<std::string, std::vector<double>> shape_ms_;  ///< answers to shapes that moved, by mode
  ViewerTimes times_;
  SliceWindow slices_;
  std::optional<PhotographWindow> photographs_;
  std::string title_, chosen_, note_;
  Mouse mouse_;
  Strokes strokes_{editing_, shaping_};
  Stopwatch played_;  ///< since the light in hand turned
  Answers answers_;
  std::unique_ptr<Comparison> comparison_;
};

}  // namespace

ViewerTimes view(const render::Scene& scene, render::LiveScene& live,
                 const ViewerOptions& options) {
  return Viewer(scene, live, options).run();
}

}  // namespace kappamu::app
