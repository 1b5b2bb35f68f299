#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/edit/edited_volume.h"

namespace kappamu::app {

namespace {

struct EditOptions {
  std::string volume, recipe;
  std::string out;
  std::size_t most_voxels = io::default_most_voxels;
};

void run_edit(const EditOptions& options, const Globals& globals) {
  const auto progress = make_progress();
  const render::Recipe recipe = render::read_recipe(options.recipe);
  const EditedVolume edited = write_edited(options.volume, recipe, options.recipe, options.out,
                                           "edit", {options.recipe}, options.most_voxels);
  for (const std::string& warning : edited.warnings) progress->warn(warning);
  if (globals.json) {
    print_json({{"volume", edited.source.string()},
                {"edits", recipe.edits.size()},
                {"files", edited.files},
                {"warnings", edited.warnings}});
    return;
  }
  for (const std::string& file : edited.files) std::printf("%s\n", file.c_str());
}

}  // namespace

void add_edit(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("edit",
                                     R"(Change κ and μ of a volume by a recipe of edits.

VOLUME is a .vdb file, a run folder, or a folder with volume.json. The recipe, a JSON file
of format kappamu-edit (docs/formats.md, "Edits"), lists edits in order. Each multiplies,
adds, sets, blends or copies coefficients of all channels or some, in a box, in a range of
depths below faces, under a texture, under a brush's strokes, or everywhere. Into OUT go:

  volume.vdb   the edited volume; `kappamu export OUT` and scenes take it
  recipe.json  the recipe, its images named from OUT

The same recipe on the same volume gives equal bits. kappa is held within 0.0001 to 10000 mm
and mu within 0 to 10000 1/mm; a warning counts the coefficients held at these bounds.
Standard deviations are scaled with their coefficients, zero where a number is set, and copied
by a copy; resolution and sensitivity stay those of the measurement.)");
  auto options = std::make_shared<EditOptions>();
  command->add_option("volume", options->volume, "What to edit")->required()->type_name("VOLUME");
  command->add_option("--recipe", options->recipe, "The edits")->required()->type_name("FILE");
  add_out(*command, options->out, "Folder for the files; made if missing");
  add_most_voxels(*command, options->most_voxels);
  command->footer(
      "Prints the files' names; with --json one object with volume, edits, files and warnings.\n"
      "Example: kappamu edit demo/run --recipe recipe.json -o demo/edited");
  command->callback([options, &globals] { run_edit(*options, globals); });
}

}  // namespace kappamu::app
