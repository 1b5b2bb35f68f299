#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "app/options/model_options.h"
#include "app/render_frames.h"
#include "core/error.h"
#include "forward/polygrid/polygrid_model.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/registry.h"
#include "io/atomic_file.h"
#include "io/polycube_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/owned_files.h"
#include "pipeline/verify.h"
#include "render/machine_costs.h"
#include "render/render_scene.h"
#include "render/scene/model_schema.h"
#include "render/scene/new_scene.h"
#include "render/scene/world.h"

namespace kappamu::app {

namespace {

struct RenderArguments {
  std::string scene, new_scene, polycube, frames, out;
  int turntable = 0;
  ModelArguments model;
};

void write_new_scene(const RenderArguments& arguments, const Globals& globals) {
  const std::filesystem::path file(arguments.out);
  pipeline::require_absent(file);
  io::write_text_atomically(file, render::new_scene(arguments.new_scene, file.parent_path()));
  if (globals.json) {
    print_json({{"scene", file.string()}});
  } else {
    std::printf("%s\n", file.c_str());
  }
}

/// Of one of the scene's objects: the program's, or the one drawn as its map has moved it.
void write_object_polycube(const RenderArguments& arguments, const Globals& globals) {
  const auto progress = make_progress();
  const std::filesystem::path file(arguments.out);
  pipeline::require_absent(file);
  const render::Scene scene = render::read_scene(arguments.scene);
  pipeline::require_as_written(render::files_of(scene));
  std::vector<std::string> warnings;
  const render::World world(scene, warnings);
  std::string names;
  for (const render::WorldObject& object : world.objects()) {
    names += (names.empty() ? "" : ", ") + object.name;
    if (object.name != arguments.polycube) continue;
    forward::PolygridOptions options;
    options.cells = forward::PolygridModel::first_cells;
    options.drawn = object.drawn();
    const forward::MadePolygrid made = forward::make_polygrid(object.mesh, options, *progress);
    io::write_polycube(made.polycube, file);
    const forward::PolygridQuality& quality = made.quality;
    if (globals.json) {
      print_json({{"polycube", file.string()},
                  {"polycube_cells", made.polycube.cells.size()},
                  {"cells", quality.cells},
                  {"least_jacobian", quality.least_jacobian},
                  {"mean_jacobian", quality.mean_jacobian},
                  {"largest_gap", quality.largest_gap},
                  {"volume_ratio", quality.volume_ratio},
                  {"warnings", made.warnings}});
      return;
    }
    std::printf("polycube             %zu cells, %d along the edge of each in a polygrid of %d\n",
                made.polycube.cells.size(), quality.refinement, quality.cells);
    std::printf("scaled Jacobian      least %.2f, mean %.2f\n", quality.least_jacobian,
                quality.mean_jacobian);
    std::printf("largest gap          %.2f spacings of boundary nodes\n", quality.largest_gap);
    std::printf("volume               %.3f times the object's\n", quality.volume_ratio);
    for (const std::string& warning : made.warnings) progress->warn(warning);
    std::printf("%s\n", file.c_str());
    return;
  }
  throw InputError(arguments.scene + ": has no object '" + arguments.polycube + "'; write one of " +
                   names);
}

/// The model of the command line in place of the scene's.
void choose_model(const ModelArguments& model, render::Scene& scene) {
  if (model.name && *model.name != scene.model.name) {
    scene.model.name = *model.name;
    scene.model.parameters.clear();
  }
  for (const auto& [name, value] : model.values()) scene.model.parameters[name] = value;
}

void run_frames(const RenderArguments& arguments, Globals& globals) {
  const render::Frames frames = arguments.turntable > 0
                                    ? render::Frames(arguments.scene, arguments.turntable)
                                    : render::Frames(arguments.scene, arguments.frames);
  render_frames(
      frames, arguments.frames, [&](render::Scene& scene) { choose_model(arguments.model, scene); },
      arguments.out, globals);
}

void run_render(const RenderArguments& arguments, Globals& globals) {
  const auto progress = make_progress();
  render::Scene scene = render::read_scene(arguments.scene);
  choose_model(arguments.model, scene);
  pipeline::require_as_written(render::files_of(scene));
  const std::filesystem::path out(arguments.out);
  pipeline::OutputFolder folder(
      out, "render", render::files_of(scene),
      {"picture.exr", "picture.png", "exitance.npy", "error.npy", "surface.npy", "summary.json"});
  render::RenderOptions options{globals.device, globals.seed};
  if (forward::object_model(scene.model.name).can.chooses)
    options.costs = render::read_machine_costs(globals.device);
  const std::unique_ptr<forward::ObjectModel> model = forward::make_object_model(
      scene.model.name, forward::ModelError::warned, scene.model.parameters);
  const render::RenderResult result = render::render_scene(scene, *model, options, *progress);
  const std::string summary = render::write_render(result, scene, options, folder.partial());
  folder.commit();
  for (const std::string& warning : result.warnings) progress->warn(warning);
  if (!result.converged) {
    progress->warn("the answer is not within the tolerance; outputs are kept and marked");
    globals.exit_code = 3;
  }
  if (globals.json) {
    print_json(nlohmann::ordered_json::parse(summary));
    return;
  }
  for (const render::ObjectReport& object : result.objects) {
    const render::ChannelReport& green = object.channels[1];
    std::printf(
        "%-20s %zu triangles, %zu elements, error %.2g %% against transport (of numerics or noise "
        "%.2g %%); error.npy says where\n",
        object.name.c_str(), object.samples, green.elements, 100.0 * green.error,
        100.0 * green.error_estimate);
    for (const forward::ModelCandidate& candidate : object.candidates) {
      std::printf("  %-18s %s\n", candidate.model.c_str(), candidate.reason.c_str());
    }
  }
  std::printf("seconds              scene %.1f, light %.1f, model %.1f, picture %.1f\n",
              result.scene_seconds, result.light_seconds, result.model_seconds,
              result.picture_seconds);
  std::printf("noise of the picture %.2g %%\n", 100.0 * result.picture.standard_error);
  std::printf("picture              %s\n", (out / "picture.png").c_str());
}

/// A flag that prints a text in place of what the command does.
CLI::Option* add_printed(CLI::App& command, const char* flag, const char* text,
                         std::string (*printed)()) {
  return command.add_flag_callback(
      flag,
      [printed] {
        std::printf("%s", printed().c_str());
        throw CLI::Success();
      },
      text);
}

}  // namespace

void add_render(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "render", std::string(R"(Render objects of measured or published materials under any light.

SCENE is a file of format kappamu-scene (docs/scene.md): objects (a mesh or a named shape,
its size, its material), lights, camera, film, model. Into OUT go:

  picture.exr    radiance, linear R, G, B, per unit of irradiance; A: coverage
  picture.png    the same, exposed and tone-mapped, for a screen
  exitance.npy   [3][sample] what leaves each triangle, scattered, relative to the lights
  surface.npy    [sample][7] position [mm], outward normal, area [mm2] of each triangle
  error.npy      [3][sample] what the exitance errs by at most, relative, in 95 of 100 places
  summary.json   power in, out and absorbed; errors, seconds, warnings

The error is against transport, numerics and the model's physics together, as measured on
other objects; of the model that solves transport it is noise alone.

)") + models_text());
  auto arguments = std::make_shared<RenderArguments>();
  auto* scene =
      command->add_option("scene", arguments->scene, "What to render")->type_name("SCENE");
  auto* made = command
                   ->add_option("--new-scene", arguments->new_scene,
                                "Write a commented scene to OUT instead: of a run folder or .vdb, "
                                "of a mesh file, or of a published material such as marble")
                   ->type_name("RUN|MESH|NAME");
  scene->excludes(made);
  auto* polycube =
      command
          ->add_option("--polycube", arguments->polycube,
                       "Write the polycube of this object to OUT instead, and how good a polygrid "
                       "it gives: draw a better one (docs/formats.md) and name its file in the "
                       "scene as the object's \"polycube\"")
          ->needs(scene)
          ->type_name("OBJECT");
  auto* frames = command
                     ->add_option("--frames", arguments->frames,
                                  "Render the frames of this file of keyframes instead: numbered "
                                  "pictures, and a film where ffmpeg is installed")
                     ->needs(scene)
                     ->type_name("FILE");
  auto* turntable = command
                        ->add_option("--turntable", arguments->turntable,
                                     "Render N frames of the camera going once round its target")
                        ->needs(scene)
                        ->excludes(frames)
                        ->check(CLI::Range(1, 100000))
                        ->type_name("N");
  frames->excludes(polycube);
  turntable->excludes(polycube);
  std::vector<std::string> names;
  for (const forward::ModelDescription& model : forward::object_models())
    names.push_back(model.name);
  add_model_options(*command, arguments->model, "Model of light, instead of the scene's", names);
  add_printed(*command, "--models-page", "The page docs/reference/models.md", models_page)
      ->group("");
  add_printed(*command, "--model-schema",
              "Print the JSON schema of a scene's \"model\", with every parameter, and exit",
              render::model_schema);
  add_out(*command, arguments->out,
          "Folder for the files; with --new-scene and --polycube the file");
  command->footer(
      "Exit code 3: the answer is not within the tolerance; outputs are kept and marked.\n"
      "Example: kappamu render --new-scene demo/run -o scene.json && kappamu render scene.json -o "
      "picture\n"
      "         kappamu render scenes/spot-wax.json --polycube spot -o spot.polycube.json");
  command->callback([arguments, &globals, scene, made, polycube, frames, turntable] {
    if (made->count() > 0) {
      write_new_scene(*arguments, globals);
    } else if (polycube->count() > 0) {
      write_object_polycube(*arguments, globals);
    } else if (frames->count() + turntable->count() > 0) {
      run_frames(*arguments, globals);
    } else if (scene->count() > 0) {
      run_render(*arguments, globals);
    } else {
      throw CLI::RequiredError("SCENE or --new-scene");
    }
  });
}

}  // namespace kappamu::app
