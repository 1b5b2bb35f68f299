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
#include "app/viewer/interrupt.h"
#include "app/viewer/panel.h"
#include "app/viewer/photographs.h"
#include "app/viewer/script.h"
#include "app/viewer/slice_window.h"
#include "app/viewer/view_state.h"
#include "app/viewer/window.h"
#include "core/error.h"
#include "core/numbers/median.h"
#include "core/processor_time.h"
#include "io/image/image_file.h"
#include "pipeline/owned_files.h"

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
        commands_(commands_of(options)),
        live_(live),
        painter_(opened(scene, live.world(), options)),
        models_(render::live_models(live.world())),
        state_(first_state(scene, live)),
        first_camera_(state_.camera),
        exposure_given_(scene.film.exposure.has_value()),
        window_(options.width, options.height,
                options.script ? WindowKind::hidden : WindowKind::shown),
        corners_(live.world()),
        canvas_(corners_.geometry()),
        answers_(live) {
    if (options.run) photographs_.emplace(*options.run);
    if (painter_.is_open()) {
      state_.edits = options.edits->string();
      if (!options.script) painter_.keep_unsaved();
      if (painter_.unsaved()) note_ = "edits that were not saved are back; undo takes them away";
    }
    if (exposure_given_) state_.exposure = *scene.film.exposure;
    ask();
  }

  ViewerTimes run() {
    const InterruptWatch interrupt;
    while (!done_) {
      if (interrupt.happened()) {
        interrupted();
        break;
      }
      if (options_.script) {
        play();
        continue;
      }
      if (glfwWindowShouldClose(window_.handle()) == GLFW_TRUE && !closing_) {
        if (!painter_.unsaved()) break;
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
    if (answer_) times_.error_estimate = answer_->error_estimate;
    return times_;
  }

 private:
  /// Read before there is a window. Throws InputError where a screenshot would replace a file.
  static std::vector<script::Command> commands_of(const ViewerOptions& options) {
    if (!options.script) return {};
    std::vector<script::Command> commands = script::read(*options.script);
    for (const script::Command& command : commands) {
      const auto* shot = std::get_if<script::Screenshot>(&command);
      if (shot != nullptr) pipeline::require_absent(options.out / shot->name);
    }
    return commands;
  }

  /// With the edits of earlier windows; refused, too, before there is a window.
  static Painter opened(const render::Scene& scene, const render::World& world,
                        const ViewerOptions& options) {
    Painter painter(scene, world);
    if (options.edits && !painter.editable().empty()) painter.open(*options.edits);
    return painter;
  }

  void ask() {
    if (!asked_since_) asked_since_.emplace();
    answers_.ask({state_.lights, painter_.media(), state_.model});
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
    canvas_.set_light(corners_.light(*answer_));
    if (!exposure_given_) {
      state_.exposure = render::usual_exposure(live_.world(), *answer_, state_.camera.position_mm);
      exposure_given_ = true;
    }
    ++times_.answers;
    light_ms_.push_back(answer_->light_ms);
    model_ms_.push_back(answer_->model_ms);
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
    const std::optional<std::size_t> edited = painter_.in_hand();
    if (state_.panel) {
      obey_panel(draw_panel({models_, answer_ ? &*answer_ : nullptr, last_frame_ms_,
                             asked_since_ ? asked_since_->milliseconds() : 0.0, note_,
                             photographs_ && photographs_->count() > 0},
                            edited ? &painter_ : nullptr, state_));
    }
    if (state_.panel && state_.slice.shown && edited) {
      const render::LiveVolume& volume = painter_.volume(*edited);
      slices_.draw(volume.history().volume(), volume.axes(), first_camera_, state_.slice);
    }
    if (state_.panel && state_.photograph.shown) photographs_->draw(state_.photograph);
    if (!options_.script) {
      follow_mouse(state_);
      follow_brush();
      follow_keys();
      if (closing_) close(draw_closing_question());
    }
    if (before.model != state_.model) ask();
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
      if (event.pressed) {
        stroking_ = state_.tool == Tool::brush && state_.region.kind == Region::Kind::stroke &&
                    !ImGui::GetIO().WantCaptureMouse;
      }
      const ImVec2 size = ImGui::GetIO().DisplaySize;
      if (stroking_) {
        points.emplace_back(event.x / static_cast<double>(size.x),
                            event.y / static_cast<double>(size.y));
      }
      if (event.left || !stroking_) continue;
      paint(std::exchange(points, {}));
      end_stroke();
      stroking_ = false;
    }
    if (!points.empty()) paint(points);
  }

  void paint(const std::vector<Eigen::Vector2d>& points) {
    const render::Camera& camera = state_.camera;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const render::LookAt look(camera.position_mm, camera.target_mm, camera.up, camera.fov_deg,
                              static_cast<double>(size.x) / size.y);
    attempt([&] {
      if (painter_.stroke_through(look, points, state_.brush)) ask();
    });
  }

  Painter::Stroked end_stroke() {
    const Painter::Stroked stroked = painter_.end_stroke();
    if (stroked == Painter::Stroked::nothing_changed) note_ = "this stroke changes no voxel";
    if (stroked == Painter::Stroked::kept) note_.clear();
    return stroked;
  }

  void follow_keys() {
    for (const KeyEvent& event : window_.take_key_events()) {
      if (!event.control || ImGui::GetIO().WantTextInput || closing_) continue;
      if (event.key == GLFW_KEY_Z) obey(event.shift ? Asked::redo : Asked::undo);
      if (event.key == GLFW_KEY_Y) obey(Asked::redo);
      if (event.key == GLFW_KEY_S) obey(Asked::save);
    }
  }

  /// What cannot be done is noted, and the window keeps what it holds; a script ends there. Whether
  /// it was done.
  template <class Action>
  bool attempt(const Action& action) {
    try {
      action();
      return true;
    } catch (const InputError& error) {
      if (options_.script) throw InputError(options_.script->string() + ": " + error.what());
      note_ = error.what();
      return false;
    }
  }

  bool save() {
    return attempt([&] {
      if (state_.edits.empty()) throw InputError("name a folder for edits (--edits OUT)");
      if (!painter_.is_open() || options_.edits != state_.edits) {
        painter_.open(state_.edits);
        options_.edits = state_.edits;
      }
      const std::vector<std::string> files = painter_.save(times_.warnings);
      times_.saved.insert(times_.saved.end(), files.begin(), files.end());
      note_ = "saved in " + state_.edits;
    });
  }

  void close(Closing closing) {
    if (closing == Closing::undecided) return;
    closing_ = false;
    glfwSetWindowShouldClose(window_.handle(), GLFW_FALSE);
    if (closing == Closing::discard) painter_.discard();
    done_ = closing == Closing::discard || (closing == Closing::save && save());
  }

  void interrupted() {
    times_.interrupted = true;
    for (const std::filesystem::path& file : painter_.unsaved_files()) {
      times_.warnings.push_back("edits that were not saved are kept in " + file.string() +
                                "; the same command continues from them");
    }
  }

  void set_title() {
    std::string title = options_.title + (painter_.unsaved() ? " * not saved" : "") + " - kappamu";
    if (title == title_) return;
    title_ = std::move(title);
    glfwSetWindowTitle(window_.handle(), title_.c_str());
  }

  void preview(const render::Edit& edit) {
    attempt([&] {
      painter_.preview(edit);
      note_.clear();
      ask();
    });
  }

  /// What the panel shows is kept, though it was changed since the preview.
  void obey_panel(Asked asked) {
    if (asked == Asked::preview || asked == Asked::keep) {
      preview(state_.brush.edit(state_.region.selection()));
    }
    obey(asked);
  }

  void obey(Asked asked) {
    if ((asked == Asked::undo && painter_.undo()) || (asked == Asked::redo && painter_.redo())) {
      ask();
    }
    if (asked == Asked::save) save();
    if (asked == Asked::keep) painter_.keep();
    if (asked == Asked::cancel && painter_.cancel()) ask();
  }

  /// One command of the script, once the picture is of the light as it stands.
  void play() {
    if (answers_.waiting()) {
      if (take_answer()) draw_frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return;
    }
    if (next_ == commands_.size()) {
      done_ = true;
      return;
    }
    std::visit([this](const auto& command) { obey(command); }, commands_[next_++]);
  }

  void obey(const script::Lamp& lamp) {
    if (static_cast<std::size_t>(lamp.number) > state_.lights.size()) {
      throw InputError(options_.script->string() + ": the scene has " +
                       std::to_string(state_.lights.size()) + " lights and no light " +
                       std::to_string(lamp.number));
    }
    state_.lamp = static_cast<std::size_t>(lamp.number - 1);
  }
  void obey(const script::TurnLight& turn) {
    state_.turn_light({turn.azimuth_deg, turn.elevation_deg});
    ask();
  }
  void obey(const script::ChooseModel& choice) {
    state_.model = choice.name;
    ask();
  }
  void obey(const script::Orbit& orbit) { state_.orbit(orbit.right_deg, orbit.up_deg); }
  void obey(const script::Exposure& exposure) { state_.exposure = exposure.factor; }
  void obey(script::Panel panel) { state_.panel = panel == script::Panel::on; }
  void obey(const script::Screenshot& shot) {
    // Two frames: a panel that has just appeared takes its size in the first.
    draw_frame();
    draw_frame();
    const std::filesystem::path file = options_.out / shot.name;
    io::write_image(file, canvas_.picture());
    times_.screenshots.push_back(file.string());
  }
  void obey(const Brush& brush) { state_.brush = brush; }
  void obey(const script::Paint& stroke) {
    std::vector<Eigen::Vector2d> points;
    for (std::size_t i = 0; i + 1 < stroke.points.size(); i += 2) {
      points.emplace_back(stroke.points[i] / options_.width,
                          stroke.points[i + 1] / options_.height);
    }
    paint(points);
    if (end_stroke() == Painter::Stroked::none) {
      throw InputError(options_.script->string() +
                       ": paint: no object of measured material lies under the stroke");
    }
  }
  void obey(script::Channel channel) { state_.channel = channel.number; }
  void obey(const script::Preview& asked) { preview(asked.edit); }
  void obey(const script::ShowPhotograph& show) {
    const int count = photographs_ ? photographs_->count() : 0;
    if (show.number > count) {
      throw InputError(options_.script->string() + ": photograph: there are " +
                       std::to_string(count) + " to show; a run with a fit has them");
    }
    state_.photograph = {show.number > 0, std::max(0, show.number - 1)};
  }
  void obey(const script::ShowSlice& show) {
    const std::optional<std::size_t> object = painter_.in_hand();
    const auto volumes = object ? io::named_volumes(painter_.volume(*object).history().volume())
                                : std::vector<io::NamedVolume>();
    for (std::size_t i = 0; i < volumes.size(); ++i) {
      if (volumes[i].name == show.volume) {
        state_.slice = {true, i, show.axis, show.index};
        return;
      }
    }
    throw InputError(options_.script->string() + ": slice: there is no volume '" + show.volume +
                     "'");
  }
  void obey(script::Quit) { done_ = true; }

  ViewerOptions options_;
  std::vector<script::Command> commands_;
  render::LiveScene& live_;
  Painter painter_;
  std::vector<std::string> models_;
  ViewState state_;
  const render::Camera first_camera_;  ///< that slices stand upright in
  bool exposure_given_ = false, done_ = false;
  bool stroking_ = false;  ///< the pressed button leads the brush
  bool closing_ = false;   ///< it is asked what becomes of unsaved edits
  Window window_;
  render::LitCorners corners_;
  Canvas canvas_;
  std::size_t next_ = 0;
  std::optional<render::LiveAnswer> answer_;  ///< that the picture shows
  std::optional<Stopwatch> asked_since_;
  Stopwatch since_drawn_;
  double last_frame_ms_ = 0.0;
  std::vector<double> light_ms_, model_ms_, frame_ms_;
  ViewerTimes times_;
  SliceWindow slices_;
  std::optional<PhotographWindow> photographs_;
  std::string note_, title_;
  Answers answers_;
};

}  // namespace

ViewerTimes view(const render::Scene& scene, render::LiveScene& live,
                 const ViewerOptions& options) {
  return Viewer(scene, live, options).run();
}

}  // namespace kappamu::app
