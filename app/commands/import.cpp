#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/photograph_options.h"
#include "app/session_command.h"
#include "capture/import/import.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct ImportArguments {
  std::string photographs, plan, out, table;
  std::optional<capture::Orientation> orientation;
  capture::Links links = capture::Links::within;
};

void run_import(const ImportArguments& arguments, const Globals& globals) {
  const auto progress = make_progress();
  pipeline::require_apart(arguments.out, {arguments.plan});
  // Photographs may lie in the session's folder already.
  if (!pipeline::holds(arguments.out, arguments.photographs)) {
    pipeline::require_apart(arguments.out, {arguments.photographs});
  }
  capture::ImportOptions options{
      arguments.photographs, arguments.plan, arguments.out, {}, arguments.links};
  if (!arguments.table.empty()) options.table = arguments.table;
  options.orientation = arguments.orientation;
  const capture::Session session = capture::import_session(options, *progress);
  const std::string file = (session.folder / "session.json").string();
  std::size_t frames = 0;
  for (const capture::Pattern& pattern : session.patterns) frames += pattern.frames.size();
  const capture::Camera& camera = session.camera;
  if (globals.json) {
    print_json({{"session", file},
                {"patterns", session.patterns.size()},
                {"frames", frames},
                {"boards", session.calibration.camera_boards.size()},
                {"planes", session.calibration.projector_planes.size()},
                {"width", camera.width},
                {"height", camera.height},
                {"bit_depth", camera.bit_depth}});
    return;
  }
  std::printf("%zu patterns in %zu frames, %zu boards, %zu planes, %d x %d pixels of %d bits\n",
              session.patterns.size(), frames, session.calibration.camera_boards.size(),
              session.calibration.projector_planes.size(), camera.width, camera.height,
              camera.bit_depth);
  std::printf("%s\n", file.c_str());
}

}  // namespace

void add_import(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("import",
                                     R"(Build a capture session from a folder of photographs.

Exposure times, aperture, sensitivity and camera are read from EXIF; size, depth and
encoding from the files (RAW: linear; JPEG: 8 bits behind a curve to be recovered). File
names tell the shot: <pattern>_<n>, board_<n>, plane_<n>_board, plane_<n>_projected,
plane_<n>_gray_<k>, plane_<n>_phase_<k>, sample_<station>, dark_<n>, white_<n>, black_<n>,
level_<value>_<n>, off_<n>, ambient_<m>_<n>, chart_<n>, with any image ending, in any
subfolder. Or a CSV does (--table): columns file, shot (the same, without the last _<n> of
stacks and boards) and, where EXIF does not tell it or tells a wrong one, exposure_s. Cells
end at commas, semicolons or tabs. Hidden files and system folders are passed over.

Photographs are taken as they are stored. Where all carry one EXIF orientation, because the
camera hung upside down, --orientation apply has every frame turned by it when it is read;
tags that differ are ignored.

What photographs cannot tell (sample, projector, boards, stations, patterns) comes from
PLAN/session.json, as `kappamu plan` writes it or written by hand (docs/formats.md); its
frames and the camera's size are replaced.

Refused, one sentence each: another aperture, sensitivity, focal length or camera than the
rest; a photograph of no shot, or a shot without photographs; no exposure time; a frame
whose brightness does not fit its exposure time.)");
  auto arguments = std::make_shared<ImportArguments>();
  command->add_option("photographs", arguments->photographs, "Folder of the photographs")
      ->required()
      ->type_name("FOLDER");
  command->add_option("--plan", arguments->plan, "Folder with the session.json to fill")
      ->required()
      ->type_name("PLAN");
  add_out(*command, arguments->out,
          "Session folder; photographs are copied into it unless they lie there already",
          "SESSION");
  command->add_option("--table", arguments->table, "CSV: file, shot, exposure_s")->type_name("CSV");
  add_orientation(*command, arguments->orientation);
  add_follow_links(*command, arguments->links);
  command->footer("Example: kappamu import photographs --plan plan -o session");
  command->callback([arguments, &globals] { run_import(*arguments, globals); });
}

}  // namespace kappamu::app
