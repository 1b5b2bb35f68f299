#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "core/error.h"
#include "pipeline/verify.h"

namespace kappamu::app {

namespace {

void run_verify(const std::string& run, const Globals& globals) {
  const auto progress = make_progress();
  const pipeline::Verification found = pipeline::verify_folder(run, *progress);
  progress->update("verify", 1.0, "");
  if (globals.json) {
    nlohmann::ordered_json found_here{{"run", run},
                                      {"whole", found.damaged() == 0},
                                      {"files", found.files},
                                      {"bytes", found.bytes},
                                      {"findings", nlohmann::json::array()}};
    for (const pipeline::Finding& f : found.findings)
      found_here["findings"].push_back({{"what", to_string(f.what)}, {"name", f.name}});
    print_json(found_here);
  } else {
    for (const pipeline::Finding& f : found.findings)
      std::printf("%-14s %s\n", to_string(f.what).c_str(), f.name.c_str());
    std::printf("%zu files compared (%.1f MB), %zu damaged\n", found.files,
                1e-6 * static_cast<double>(found.bytes), found.damaged());
  }
  if (found.damaged() > 0)
    throw InputError(run + ": " + std::to_string(found.damaged()) +
                     " of its files or inputs are missing or changed; `kappamu run` with the same "
                     "input makes them again");
}

}  // namespace

void add_verify(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("verify",
                                     R"(Check that a run folder is as kappamu wrote it.

Reads every file that run.json or kappamu-files.json lists, and every file of the input,
and compares its contents with the recorded hash. Prints a line per finding:

  missing, changed               a result is lost or damaged
  input missing, input changed   a file that the results were made from
  unfinished                     a stage that was cut short: run it again
  foreign                        a file that kappamu did not write; it is left alone
  no input                       the input folder is not there and was not compared

Hashes detect damage and edits. They do not protect against someone who changes a file and
its record together.)");
  auto run = std::make_shared<std::string>();
  command->add_option("run", *run, "Run folder, or a folder that fit, export or plan filled")
      ->required()
      ->type_name("RUN");
  command->footer(
      R"(Exit code 1: the first two kinds were found. With --json one object: run, whole, files,
bytes, findings (what, name).
Example: kappamu verify demo/run)");
  command->callback([run, &globals] { run_verify(*run, globals); });
}

}  // namespace kappamu::app
