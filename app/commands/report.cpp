#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "core/error.h"
#include "pipeline/output_folder.h"
#include "pipeline/run_folder.h"
#include "pipeline/verify.h"
#include "report/report.h"

namespace kappamu::app {

namespace {

namespace fs = std::filesystem;

fs::path write(const fs::path& run) {
  fs::path file = pipeline::canonical_path(run) / "report.html";
  if (fs::exists(run / "run.json")) {
    pipeline::RunFolder folder(run);
    for (const char* read : {"calibrate", "fit"}) folder.require_whole(read);
    folder.require_whole_but("hdr", "merge");
    const auto earlier = folder.record().stages.find("report");
    const std::string key =
        earlier == folder.record().stages.end() ? "by hand" : earlier->second.key;
    Progress silent;
    folder.run({"report", key, {"report.html"}}, silent, [&](const fs::path& output, Progress&) {
      report::write_report(run, output / "report.html");
    });
    return file;
  }
  // A folder that `kappamu fit` and the like filled; what it holds is for the report to say.
  if (!fs::is_directory(run)) {
    throw InputError(run.string() + ": no such run folder; make one with `kappamu run`");
  }
  pipeline::require_as_written(run);
  pipeline::OutputFolder folder(run, "report", {}, {"report.html"});
  report::write_report(run, folder.partial() / "report.html");
  folder.commit();
  return file;
}

}  // namespace

void add_report(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "report",
      R"(Write RUN/report.html: one self-contained page that shows whether to trust a fit.

On top the fit's verdict (fit.json has the same), with one line each for fit, validation,
coverage, calibration and warnings. Below it measured and re-rendered pictures with
residual maps, slices of κ [mm] and μ [1/mm], convergence, what was captured, calibration
residuals, response, dynamic range, times, device and versions. Parts the run does not
have are left out with a sentence.)");
  auto run = std::make_shared<std::string>();
  command->add_option("run", *run, "Run folder, as written by `kappamu run`")
      ->required()
      ->type_name("RUN");
  command->footer("Example: kappamu report demo/run && xdg-open demo/run/report.html");
  command->callback([run, &globals] {
    const std::filesystem::path path = write(*run);
    if (globals.json)
      print_json({{"report", path.string()}});
    else
      std::printf("%s\n", path.c_str());
  });
}

}  // namespace kappamu::app
