#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/command.h"
#include "app/options/model_options.h"
#include "app/viewer/viewer.h"
#include "core/error.h"
#include "core/process_memory.h"
#include "forward/registry.h"
#include "io/atomic_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/verify.h"
#include "render/scene/new_scene.h"

namespace kappamu::app {

namespace {

struct ViewArguments {
  std::string scene;
  std::optional<std::string> script;
  ModelArguments model;
  std::optional<double> tolerance;
  std::optional<int> width;
  std::string out = ".";
  std::optional<std::string> edits;
};

/// Removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = (std::filesystem::temp_directory_path() / "kappamu-view-XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) {
      throw InputError(path_ + ": cannot be made; set TMPDIR to a folder that can be written");
    }
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path path() const { return path_; }

 private:
  std::string path_;
};

/// A scene file, or the first scene of a run, a volume or a mesh, the object between two lamps,
/// which lies in `folder` as long as it is used.
render::Scene scene_of(const std::string& path, std::optional<TemporaryFolder>& folder) {
  if (!render::begins_scene(path)) return render::read_scene(path);
  folder.emplace();
  const std::filesystem::path file = folder->path() / "scene.json";
  io::write_text_atomically(file, render::new_scene(path, folder->path()));
  return render::read_scene(file);
}

/// In the current folder: NAME-edits, of the scene's or the run's name.
std::filesystem::path usual_edits(const std::string& scene) {
  const std::filesystem::path path = pipeline::canonical_path(scene);
  return (std::filesystem::is_directory(path) ? path.filename() : path.stem()).string() + "-edits";
}

/// Whether another file is to be looked at, which `arguments` then have.
bool look_at(ViewArguments& arguments, const Globals& globals) {
  constexpr int usual_width = 1280;
  ViewerOptions options;
  const auto progress = make_progress();
  std::optional<TemporaryFolder> folder;
  const render::Scene scene = scene_of(arguments.scene, folder);
  pipeline::require_as_written(render::files_of(scene));
  options.script = arguments.script;
  options.out = arguments.out;
  options.title = arguments.scene;
  options.edits = arguments.edits;
  if (!options.script && !options.edits) options.edits = usual_edits(arguments.scene);
  if (folder) options.run = arguments.scene;
  options.width = arguments.width.value_or(
      options.script ? scene.film.width : std::max(usual_width, scene.film.width));
  options.height = std::max(1, options.width * scene.film.height / scene.film.width);
  const render::LiveOptions of_models{arguments.model.name, arguments.tolerance, globals.device,
                                      globals.seed, arguments.model.values()};
  const LiveMaker make = [&](const render::ShapesKnown& shapes_known) {
    std::vector<std::string> warnings;
    auto live = std::make_unique<render::LiveScene>(scene, of_models, warnings, shapes_known);
    for (const std::string& warning : warnings) progress->warn(warning);
    return live;
  };
  options.another = [&scene, &of_models] {
    std::vector<std::string> known;
    return std::make_unique<render::LiveScene>(scene, of_models, known);
  };
  options.check = [](const std::string& path) {
    std::optional<TemporaryFolder> other;
    scene_of(path, other);
  };
  const ViewerTimes times = view(scene, make, options);
  for (const std::string& warning : times.warnings) progress->warn(warning);
  if (times.interrupted) {
    std::signal(SIGINT, SIG_DFL);
    std::raise(SIGINT);
  }
  if (times.opened) {
    arguments.scene = *times.opened;
    arguments.edits.reset();
    return true;
  }
  if (globals.json) {
    const auto known = [](const std::optional<double>& value) {
      return value ? nlohmann::json(*value) : nlohmann::json();
    };
    const nlohmann::json summary{{"model", times.last.model},
                                 {"models", times.models},
                                 {"answers", times.answers},
                                 {"frames", times.frames},
                                 {"light_ms", times.light_ms},
                                 {"model_ms", times.model_ms},
                                 {"shape_ms", times.shape_ms},
                                 {"frame_ms", times.frame_ms},
                                 {"event_ms", times.event_ms},
                                 {"picture_ms", times.picture_ms},
                                 {"picture_processor_ms", times.picture_processor_ms},
                                 {"memory_bytes", peak_memory()},
                                 {"first_picture_s", times.first_picture_s},
                                 {"first_light_s", times.first_light_s},
                                 {"settled_s", times.settled_s},
                                 {"elements", times.last.elements},
                                 {"error_estimate", known(times.last.error_estimate)},
                                 {"model_error", known(times.last.model_error)},
                                 {"screenshots", times.screenshots},
                                 {"saved", times.saved},
                                 {"warnings", times.warnings}};
    print_json(summary);
    return false;
  }
  std::printf("model                %s, %zu elements, error %.2g %%\n", times.last.model.c_str(),
              times.last.elements, 100.0 * times.last.error().value_or(0.0));
  std::printf("since the start      first picture %.1f s, first light %.1f s, settled %.1f s\n",
              times.first_picture_s, times.first_light_s, times.settled_s);
  std::printf(
      "medians              light %.0f ms, diffusion %.0f ms, drawing %.1f ms, "
      "from a change to its picture %.0f ms\n",
      times.light_ms, times.model_ms, times.frame_ms, times.event_ms);
  for (const std::string& screenshot : times.screenshots) {
    std::printf("screenshot           %s\n", screenshot.c_str());
  }
  for (const std::string& file : times.saved)
    std::printf("saved                %s\n", file.c_str());
  return false;
}

void run_view(ViewArguments arguments, const Globals& globals) {
  while (look_at(arguments, globals)) continue;
}

}  // namespace

void add_view(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "view",
      R"(Turn lights round objects in a window, their diffusion solved again each time.

SCENE is what `kappamu render` takes; of a RUN or a .vdb file it is the measured block between
two lamps, of a mesh file (OBJ, PLY, STL, glTF) its shape in marble.
F1 in the window lists keys and mouse. A coarse picture comes first and sharpens while nothing
moves, up to the tolerance. The window states model, error and what it computes.

While anything moves, reflections and light scattered once are drawn in approximation. At rest
the picture is traced as `kappamu render` does it, ray by ray, until something moves again.

Edits change any object's kappa and mu, or colour and mean free path: under a brush's stroke
down to a depth, in a box, a layer, below an image thrown from the view or laid on a face, or
everywhere. They are listed, reordered, switched off, undone and done again, and saved as
`kappamu edit` does: a volume, the recipe that makes it, and a scene. The same command continues
from saved edits, and from those of a window that ended before they were saved.

A script has one command per line: lamp N, light AZ EL, turn DEGREES,
distance MM, brightness R G B, model NAME, orbit DX DY (degrees),
exposure E, panel on|off, trace on|off, channel all|R|G|B,
brush OPERATION kappa|mu|albedo|mean_free_path AMOUNT RADIUS DEPTH, paint X Y ...,
fur NAME VALUE, fur_brush KIND RADIUS ..., comb X0 Y0 X1 Y1 RADIUS,
tool orbit|brush|shape|fur, mouse left|right|middle X0 Y0 X1 Y1,
compare unedited|now|off, preview RECIPE, keep, cancel, undo, redo,
slice NAME x|y|z N, photograph N, save, screenshot NAME, quit. docs/howto/view.md has all.)");
  auto arguments = std::make_shared<ViewArguments>();
  command->add_option("scene", arguments->scene, "What to look at")
      ->required()
      ->type_name("SCENE|RUN|MESH");
  add_model_options(
      *command, arguments->model,
      "Model of light; by itself of those that follow lights (\"live\", `kappamu render "
      "--help`) the one that keeps up while lights move, and at rest the one that "
      "errs least; the window changes it",
      forward::object_model_names());
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "Relative error asked of the picture at rest; by itself the scene's")
      ->check(CLI::Range(1e-6, 1.0));
  command->add_option("--width", arguments->width, "Of the picture [px]")
      ->check(CLI::Range(16, 16384));
  command->add_option("--script", arguments->script, "Play this file with the window hidden")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command
      ->add_option("-o,--out", arguments->out,
                   "Folder of the script's screenshots; made if missing")
      ->type_name("OUT");
  command
      ->add_option(
          "--edits", arguments->edits,
          "Folder that edited volumes are saved to, with their recipe; left out, NAME-edits "
          "in the current folder, of the scene's or run's NAME")
      ->type_name("OUT");
  command->footer(
      "Example: kappamu view demo/run\n"
      "         xvfb-run -a kappamu view scene.json --script turn.txt -o pictures");
  command->callback([arguments, &globals] { run_view(*arguments, globals); });
}

}  // namespace kappamu::app
