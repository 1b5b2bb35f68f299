#include "app/viewer/viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>

#include "app/viewer/answers.h"
#include "app/viewer/canvas.h"
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
        models_(render::live_models(live.world())),
        state_(first_state(scene, live)),
        exposure_given_(scene.film.exposure.has_value()),
        window_(options.width, options.height,
                options.script ? WindowKind::hidden : WindowKind::shown),
        corners_(live.world()),
        canvas_(corners_.geometry()),
        painter_(scene, live.world()),
        answers_(live) {
    if (options.run) photographs_.emplace(*options.run);
    if (exposure_given_) state_.exposure = *scene.film.exposure;
    ask();
  }

  ViewerTimes run() {
    while (glfwWindowShouldClose(window_.handle()) == GLFW_FALSE && !done_) {
      if (options_.script) {
        play();
        continue;
      }
      // Drawing takes from diffusion what it needs of the processor: only where the picture
      // changes.
      const bool changed = window_.wait_for_events(longest_wait_s);
      if (take_answer() || changed || label_changes()) draw_frame();
    }
    done_ = true;
    if (!options_.script && unsaved_ && options_.edits) save();
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
    const std::optional<std::size_t> paintable = painter_.first_volume();
    if (state_.panel) {
      obey(draw_panel({models_, answer_ ? &*answer_ : nullptr, last_frame_ms_,
                       asked_since_ ? asked_since_->milliseconds() : 0.0, saved_,
                       photographs_ && photographs_->count() > 0},
                      paintable ? &painter_ : nullptr, state_));
    }
    if (state_.panel && state_.slice.shown && paintable) {
      slices_.draw(painter_.volume(*paintable)->history().volume(), state_.slice);
    }
    if (state_.panel && state_.photograph.shown) photographs_->draw(state_.photograph);
    if (!options_.script) {
      follow_mouse(state_);
      follow_brush();
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

  /// The brush follows the pressed left button over the picture.
  void follow_brush() {
    const ImGuiIO& io = ImGui::GetIO();
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      unsaved_ = painter_.end_stroke() || unsaved_;
    } else if (state_.tool == Tool::brush && state_.region.kind == Region::Kind::stroke &&
               !io.WantCaptureMouse) {
      paint(io.MousePos.x / io.DisplaySize.x, io.MousePos.y / io.DisplaySize.y);
    }
  }

  void paint(double x, double y) {
    const render::Camera& camera = state_.camera;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const render::LookAt look(camera.position_mm, camera.target_mm, camera.up, camera.fov_deg,
                              static_cast<double>(size.x) / size.y);
    if (painter_.stroke_to(look, x, y, state_.brush)) ask();
  }

  void save() {
    if (!options_.edits) {
      saved_ = "name a folder for edits: kappamu view ... --edits OUT";
      if (options_.script) throw InputError(options_.script->string() + ": save: " + saved_);
      return;
    }
    try {
      times_.saved = painter_.save(*options_.edits, times_.warnings);
      saved_ = "saved in " + options_.edits->string();
      unsaved_ = false;
    } catch (const InputError& error) {  // the window keeps what it holds
      if (options_.script || done_) throw;
      saved_ = error.what();
    }
  }

  void preview(const render::Edit& edit) {
    try {
      painter_.preview(edit);
      saved_.clear();
      ask();
    } catch (const InputError& error) {
      if (options_.script) throw;
      saved_ = error.what();
    }
  }

  void obey(Asked asked) {
    if ((asked == Asked::undo && painter_.undo()) || (asked == Asked::redo && painter_.redo())) {
      unsaved_ = true;
      ask();
    }
    if (asked == Asked::save) save();
    if (asked == Asked::preview) preview(state_.brush.edit(state_.region.selection()));
    if (asked == Asked::keep) unsaved_ = painter_.keep() || unsaved_;
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
    for (std::size_t i = 0; i + 1 < stroke.points.size(); i += 2) {
      paint(stroke.points[i] / options_.width, stroke.points[i + 1] / options_.height);
    }
    if (!painter_.end_stroke()) {
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
    const std::optional<std::size_t> object = painter_.first_volume();
    const auto volumes = object ? io::named_volumes(painter_.volume(*object)->history().volume())
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
  std::vector<std::string> models_;
  ViewState state_;
  bool exposure_given_ = false, done_ = false;
  bool unsaved_ = false;  ///< strokes since the last saving
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
  Painter painter_;
  SliceWindow slices_;
  std::optional<PhotographWindow> photographs_;
  std::string saved_;
  Answers answers_;
};

}  // namespace

ViewerTimes view(const render::Scene& scene, render::LiveScene& live,
                 const ViewerOptions& options) {
  return Viewer(scene, live, options).run();
}

}  // namespace kappamu::app
