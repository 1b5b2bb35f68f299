#include "app/viewer/viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "app/viewer/answers.h"
#include "app/viewer/canvas.h"
#include "app/viewer/editing.h"
#include "app/viewer/interrupt.h"
#include "app/viewer/panel.h"
#include "app/viewer/panel/photographs.h"
#include "app/viewer/panel/slice_window.h"
#include "app/viewer/script_player.h"
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
  if (values.empty()) return 0.0;
  return upper_median(std::move(values));
}

/// How long the window waits for a person before it looks for an answer [s].
constexpr double longest_wait_s = 0.005;
constexpr double label_period_ms = 100.0;

ViewState first_state(const render::Scene& scene, const render::LiveScene& live) {
  const render::World& world = live.world();
  ViewState state;
  state.model = live.model();
  state.lights = scene.lights;
  state.camera = scene.camera;
  Eigen::AlignedBox3d box;
  for (const render::WorldObject& object : world.objects()) {
    for (const Eigen::Vector3d& vertex : object.mesh.vertices) {
      box.extend(object.world_from_object * vertex);
    }
  }
  state.centre = box.center();
  const auto first = std::find_if(state.lights.begin(), state.lights.end(), render::has_angles);
  if (first != state.lights.end()) {
    state.lamp = static_cast<std::size_t>(first - state.lights.begin());
  }
  return state;
}

class Viewer {
 public:
  Viewer(const render::Scene& scene, render::LiveScene& live, const ViewerOptions& options)
      : options_(options),
        player_(options),
        live_(live),
        editing_(scene, live.world(), options, [this] { ask(); }),
        shaping_(scene, live.world()),
        state_(first_state(scene, live)),
        first_camera_(state_.camera),
        exposure_given_(scene.film.exposure.has_value()),
        window_(options.width, options.height,
                options.script ? WindowKind::hidden : WindowKind::shown),
        corners_(live.world()),
        canvas_(corners_.geometry()),
        answers_(live) {
    if (options.run) photographs_.emplace(*options.run);
    if (editing_.painter().is_open()) state_.edits = options.edits->string();
    if (exposure_given_) state_.exposure = *scene.film.exposure;
    groups_.push_back(light_group());
    groups_.push_back(view_group(photograph_count() > 0));
    groups_.push_back(shape_group(shaping_));
    groups_.push_back(edit_group(editing_.painter()));
    groups_.push_back(material_group(editing_.painter()));
    groups_.push_back(model_group(render::live_models(live.world())));
    ask();
  }

  ViewerTimes run() {
    const InterruptWatch interrupt;
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
      const bool changed = window_.wait_for_events(longest_wait_s);
      const bool answered = take_answer();
      if (answered) window_.draw_again();
      if (answered || changed || label_changes()) draw_frame();
    }
    times_.light_ms = median(light_ms_);
    times_.model_ms = median(model_ms_);
    times_.frame_ms = median(frame_ms_);
    for (const auto& [mode, milliseconds] : shape_ms_) times_.shape_ms[mode] = median(milliseconds);
    if (answer_) times_.error_estimate = answer_->error_estimate;
    times_.saved = editing_.saved();
    times_.warnings = editing_.warnings();
    return times_;
  }

 private:
  int photograph_count() const { return photographs_ ? photographs_->count() : 0; }

  void ask() {
    if (!asked_since_) asked_since_.emplace();
    answers_.ask({state_.lights, editing_.painter().media(), state_.model, shaping_.question()});
  }

  bool take_answer() {
    std::optional<render::LiveAnswer> answer = answers_.take();
    if (!answer) return false;
    answer_ = std::move(answer);
    if (!answer_->refused.empty()) {
      if (options_.script)
        throw InputError(options_.script->string() + ": model: " + answer_->refused);
      state_.model = answer_->model;
    }
    if (!answer_->moved.empty()) {
      live_.show(*answer_);
      canvas_.set_geometry(corners_.geometry());
    }
    if (answer_->model_changed) state_.model = answer_->model;
    shaping_.take(*answer_);
    if (options_.script && !answer_->shape_refused.empty()) {
      throw InputError(options_.script->string() + ": " + answer_->shape_refused);
    }
    canvas_.set_light(corners_.light(*answer_));
    if (!exposure_given_) {
      state_.exposure = render::usual_exposure(live_.world(), *answer_, state_.camera.position_mm);
      exposure_given_ = true;
    }
    ++times_.answers;
    light_ms_.push_back(answer_->light_ms);
    model_ms_.push_back(answer_->model_ms);
    if (answer_->mode != "static") shape_ms_[answer_->mode].push_back(answer_->total_ms());
    asked_since_.reset();
    if (answers_.waiting()) asked_since_.emplace();
    return true;
  }

  /// The panel counts the seconds of a long answer.
  bool label_changes() const {
    return asked_since_ && since_drawn_.milliseconds() > label_period_ms;
  }

  void draw_frame() {
    const Stopwatch watch;
    set_title();
    since_drawn_ = watch;
    int width = options_.width, height = options_.height;
    if (!options_.script) glfwGetFramebufferSize(window_.handle(), &width, &height);
    if (width < 1 || height < 1) return;
    const double distance = (state_.camera.position_mm - state_.centre).norm();
    const double radius = live_.world().diameter();
    canvas_.draw(state_.camera, state_.exposure, state_.channel,
                 std::max(0.01 * distance, distance - radius), distance + radius, width, height);
    draw_over();
    if (!options_.script) {
      canvas_.show(width, height);
      glfwSwapBuffers(window_.handle());
    }
    ++times_.frames;
    last_frame_ms_ = watch.milliseconds();
    frame_ms_.push_back(last_frame_ms_);
  }

  void draw_over() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    ViewState before = state_;
    Painter& painter = editing_.painter();
    if (state_.panel) {
      const PanelNumbers numbers{answer_ ? &*answer_ : nullptr, last_frame_ms_,
                                 asked_since_ ? asked_since_->milliseconds() : 0.0,
                                 editing_.note()};
      editing_.obey_panel(draw_panel(groups_, numbers, state_), state_);
    }
    if (state_.panel && state_.slice.shown) {
      const std::size_t edited = painter.in_hand();
      slices_.draw(painter.edited(edited).history().volume(), painter.axes(edited), first_camera_,
                   state_.slice);
    }
    if (state_.panel && state_.photograph.shown) photographs_->draw(state_.photograph);
    if (!options_.script) {
      follow_mouse(state_);
      follow_brush();
      follow_keys();
      if (closing_) close(draw_closing_question());
    }
    if (before.model != state_.model || shaping_.take_change()) ask();
    if (state_.has_handle() && before.has_handle() && before.lamp == state_.lamp) {
      const auto was = render::angles_of(before.lights[state_.lamp], state_.centre);
      const auto is = render::angles_of(state_.lights[state_.lamp], state_.centre);
      if (was.azimuth_deg != is.azimuth_deg || was.elevation_deg != is.elevation_deg) ask();
    }
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }

  /// The brush follows the pressed left button over the picture, through every position that the
  /// pointer had.
  void follow_brush() {
    std::vector<Eigen::Vector2d> points;
    for (const PointerEvent& event : window_.take_pointer_events()) {
      const ImVec2 screen = ImGui::GetIO().DisplaySize;
      const Eigen::Vector2d at(event.x / static_cast<double>(screen.x),
                               event.y / static_cast<double>(screen.y));
      if (event.pressed && state_.tool == Tool::shape && !ImGui::GetIO().WantCaptureMouse) {
        shaping_.press(look(), at);
      }
      if (shaping_.pressed()) {
        shaping_.drag(look(), at);
        if (!event.left) shaping_.release();
        continue;
      }
      if (event.pressed) {
        stroking_ = state_.tool == Tool::brush && state_.region.kind == Region::Kind::stroke &&
                    !ImGui::GetIO().WantCaptureMouse;
      }
      if (stroking_) points.push_back(at);
      if (event.left || !stroking_) continue;
      paint(std::exchange(points, {}));
      editing_.end_stroke();
      stroking_ = false;
    }
    if (!points.empty()) paint(points);
  }

  render::LookAt look() const {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    return state_.look(static_cast<double>(size.x) / static_cast<double>(size.y));
  }

  void paint(const std::vector<Eigen::Vector2d>& points) {
    editing_.stroke_through(look(), points, state_.brush);
  }

  void follow_keys() {
    for (const KeyEvent& event : window_.take_key_events()) {
      if (!event.control || ImGui::GetIO().WantTextInput || closing_) continue;
      if (event.key == GLFW_KEY_Z) {
        editing_.obey(event.shift ? Asked::redo : Asked::undo, state_.edits);
      }
      if (event.key == GLFW_KEY_Y) editing_.obey(Asked::redo, state_.edits);
      if (event.key == GLFW_KEY_S) editing_.obey(Asked::save, state_.edits);
    }
  }

  void close(Closing closing) {
    if (closing == Closing::undecided) return;
    closing_ = false;
    glfwSetWindowShouldClose(window_.handle(), GLFW_FALSE);
    done_ = editing_.close(closing, state_.edits);
  }

  void set_title() {
    std::string title =
        options_.title + (editing_.painter().unsaved() ? " * not saved" : "") + " - kappamu";
    if (title == title_) return;
    title_ = std::move(title);
    glfwSetWindowTitle(window_.handle(), title_.c_str());
  }

  /// One command of the script, once the picture is of the light as it stands.
  void play() {
    if (answers_.waiting()) {
      if (take_answer()) draw_frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return;
    }
    done_ = player_.finished();
    if (done_) return;
    Stage stage{state_,
                editing_,
                shaping_,
                photograph_count(),
                [this] { ask(); },
                [this](const std::filesystem::path& file) { write_screenshot(file); }};
    player_.play(stage);
    if (shaping_.take_change()) ask();
  }

  void write_screenshot(const std::filesystem::path& file) {
    // Two frames: a panel that has just appeared takes its size in the first.
    draw_frame();
    draw_frame();
    io::write_image(file, canvas_.picture());
    times_.screenshots.push_back(file.string());
  }

  ViewerOptions options_;
  ScriptPlayer player_;
  render::LiveScene& live_;
  Editing editing_;
  Shaping shaping_;
  ViewState state_;
  const render::Camera first_camera_;  ///< that slices stand upright in
  bool exposure_given_ = false, done_ = false;
  bool stroking_ = false;  ///< the pressed button leads the brush
  bool closing_ = false;   ///< it is asked what becomes of unsaved edits
  Window window_;
  PanelGroups groups_;
  render::LitCorners corners_;
  Canvas canvas_;
  std::optional<render::LiveAnswer> answer_;  ///< that the picture shows
  std::optional<Stopwatch> asked_since_;
  Stopwatch since_drawn_;
  double last_frame_ms_ = 0.0;
  std::vector<double> light_ms_, model_ms_, frame_ms_;
  std::map<std::string, std::vector<double>> shape_ms_;  ///< answers to shapes that moved, by mode
  ViewerTimes times_;
  SliceWindow slices_;
  std::optional<PhotographWindow> photographs_;
  std::string title_;
  Answers answers_;
};

}  // namespace

ViewerTimes view(const render::Scene& scene, render::LiveScene& live,
                 const ViewerOptions& options) {
  return Viewer(scene, live, options).run();
}

}  // namespace kappamu::app
