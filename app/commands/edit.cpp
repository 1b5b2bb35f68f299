#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/command.h"
#include "app/edit/edited_volume.h"
#include "core/error.h"
#include "io/volume/volume_file.h"
#include "pipeline/verify.h"
#include "render/embree_caster.h"
#include "render/scene/object_shape.h"
#include "render/scene/scene.h"

namespace kappamu::app {

namespace {

struct EditOptions {
  std::string source, recipe;
  std::optional<std::string> object;
  std::optional<double> voxel_mm;
  std::string out;
  std::size_t most_voxels = io::default_most_voxels;
};

/// The object of the scene that is edited: the one named, or the only one.
std::size_t object_of(const render::Scene& scene, const std::optional<std::string>& name) {
  std::string names;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (name ? scene.objects[i].name == *name : scene.objects.size() == 1) return i;
    names += (names.empty() ? "" : ", ") + scene.objects[i].name;
  }
  throw InputError(scene.file.string() +
                   (name ? ": has no object '" + *name + "'" : ": has several objects") +
                   "; name one of " + names);
}

/// A scene's object with what its edits look at, or a volume by itself.
struct Opened {
  std::optional<render::Scene> scene;
  EditSource source;
  TriangleMesh rest, mesh;  ///< before its deformations, and as it is
  std::unique_ptr<RayCaster> rays;
  std::unique_ptr<render::EditedObject> edited;
};

void open_object(const EditOptions& options, const render::Recipe& recipe, Opened& opened,
                 std::vector<std::string>& warnings) {
  opened.scene = render::read_scene(options.source);
  pipeline::require_as_written(render::files_of(*opened.scene));
  opened.source = {&*opened.scene, object_of(*opened.scene, options.object), {}};
  const render::SceneObject& object = opened.scene->objects[opened.source.object];
  opened.rest = render::make_object_mesh(object, warnings);
  opened.mesh = render::deformed_body(opened.rest, object.deform);
  opened.rays = render::make_embree_caster(opened.mesh);
  opened.edited =
      std::make_unique<render::EditedObject>(object, opened.rest, opened.mesh, *opened.rays,
                                             options.voxel_mm ? options.voxel_mm : recipe.voxel_mm);
  warnings.insert(warnings.end(), opened.edited->warnings().begin(),
                  opened.edited->warnings().end());
}

void open_volume(const EditOptions& options, Opened& opened) {
  if (options.object || options.voxel_mm) {
    throw InputError(options.source +
                     ": is a volume, which has no objects and voxels of its own; leave the object "
                     "and the voxels' edge out");
  }
  opened.source = {nullptr, 0, options.source};
  pipeline::require_as_written(io::find_volume(options.source));
  opened.edited =
      std::make_unique<render::EditedObject>(io::find_volume(options.source), options.most_voxels);
}

void run_edit(const EditOptions& options, const Globals& globals) {
  const auto progress = make_progress();
  const render::Recipe recipe = render::read_recipe(options.recipe);
  Opened opened;
  std::vector<std::string> warnings;
  if (std::filesystem::path(options.source).extension() == ".json") {
    open_object(options, recipe, opened, warnings);
  } else {
    open_volume(options, opened);
  }
  apply(recipe, options.recipe, opened.edited->history(), warnings);
  if (opened.scene) {
    std::vector<render::Light> lights = opened.scene->lights;
    render::change_lights(recipe.lights, options.recipe, lights);
  } else if (!recipe.lights.empty()) {
    warnings.push_back(options.recipe + ": its lights are of a scene, and a volume has none");
  }
  opened.edited->set_lights(recipe.lights);
  if (opened.scene) opened.edited->require_body();
  const std::vector<std::string> files =
      write_edited(*opened.edited, opened.source, options.out, "edit", {options.recipe});
  for (const std::string& warning : warnings) progress->warn(warning);
  if (globals.json) {
    print_json({{"source", opened.source.name()},
                {"edits", recipe.edits.size()},
                {"files", files},
                {"warnings", warnings}});
    return;
  }
  for (const std::string& file : files) std::printf("%s\n", file.c_str());
}

}  // namespace

void add_edit(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("edit",
                         R"(Change a volume's κ and μ, or a scene object's material, by a recipe.

SOURCE is a scene (.json), a .vdb file, a run folder, or a folder with volume.json. The recipe,
a JSON file of format kappamu-edit (docs/formats.md, "Edits"), lists edits in order. Each
multiplies, adds, sets, blends or copies coefficients, colours or mean free paths of all
channels or some: in a box, in a range of depths, under an image, under a brush's strokes, or
everywhere; or it changes the surface's index and roughness, or the shape. A recipe that the
window saved may turn the scene's lights as well. Into OUT go:

  recipe.json  the recipe, its files named from OUT
  volume.vdb   the edited volume; `kappamu export OUT` and scenes take it
  scene.json   of a scene: it with the edited object and lights, for `kappamu render`

A homogeneous object becomes a volume over its box at the first edit of a part of it; a wrapped or
composed one is edited as the voxels that it is made of. Edits of all of a homogeneous object leave it one, without volume.vdb. The same
recipe on the same source gives equal bits. kappa is held within 0.0001 to 10000 mm and mu within
0 to 10000 1/mm; a warning counts the coefficients held at these bounds. Standard deviations are
scaled with their coefficients, zero where a number is set, and copied by a copy; resolution and
sensitivity stay those of the measurement.)");
  auto options = std::make_shared<EditOptions>();
  command->add_option("source", options->source, "What to edit")
      ->required()
      ->type_name("SCENE|VOLUME");
  command->add_option("--recipe", options->recipe, "The edits")->required()->type_name("FILE");
  command->add_option("--object", options->object, "Of a scene with several: the one to edit")
      ->type_name("NAME");
  command
      ->add_option(
          "--voxel", options->voxel_mm,
          "Edge of the voxels that a homogeneous object is made of [mm]; by itself the "
          "recipe's, else the smaller of a mean free path and a 64th of the object, larger "
          "where there were more than two million")
      ->check(CLI::Range(1e-6, 1e6));
  add_out(*command, options->out, "Folder for the files; made if missing");
  add_most_voxels(*command, options->most_voxels);
  command->footer(
      "Prints the files' names; with --json one object with source, edits, files and warnings.\n"
      "Example: kappamu edit demo/run --recipe recipe.json -o demo/edited");
  command->callback([options, &globals] { run_edit(*options, globals); });
}

}  // namespace kappamu::app
