#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/bench_command.h"
#include "app/command.h"
#include "bench/limits.h"
#include "io/atomic_file.h"
#include "io/read_file.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> only;
  std::string update;
  bool small = false;
};

Json to_json(const bench::LimitTable& table) {
  Json records = Json::array();
  for (const bench::Record& record : table.records) {
    Json entry = Json::object();
    for (const auto& [name, value] : record) {
      std::visit([&, key = name](const auto& figure) { entry[key] = figure; }, value);
    }
    records.push_back(entry);
  }
  return records;
}

void run_limits(const Options& options, Globals& globals) {
  const auto progress = make_progress();
  // Read first: a document that is not there should not cost the measurement.
  std::string document = options.update.empty() ? "" : io::read_text(options.update);
  std::vector<std::string> wanted = options.only;
  if (wanted.empty()) {
    for (const auto& limit : bench::limit_names()) wanted.push_back(limit.id);
  }
  Json all = Json::object();
  for (const std::string& id : wanted) {
    const bench::LimitTable table =
        bench::measure_limit(id, {globals.device, !options.small}, *progress);
    all[id] = to_json(table);
    if (!globals.json) std::printf("%s\n\n%s\n", id.c_str(), table.markdown.c_str());
    if (!options.update.empty()) document = bench::with_table(document, table, options.update);
  }
  if (!options.update.empty()) io::write_text_atomically(options.update, document);
  if (globals.json) std::printf("%s\n", all.dump().c_str());
}

}  // namespace

void add_bench_limits(CLI::App& bench, Globals& globals) {
  auto* command = bench.add_subcommand(
      "limits",
      "Measure the solver's edges: every table of docs/limits.md.\n\n"
      "  kappamu bench limits                            print them all as Markdown\n"
      "  kappamu bench limits --only contrast shape      print two of them\n"
      "  kappamu bench limits --update docs/limits.md    renew the document's tables\n\n"
      "Errors are distances to the solution of the grid's equations (double, refined in long\n"
      "double) or to closed forms; no times. --json prints every figure as one object.");
  auto options = std::make_shared<Options>();
  std::vector<std::string> names;
  std::string list;
  for (const auto& limit : kappamu::bench::limit_names()) {
    names.push_back(limit.id);
    list += "  " + limit.id + std::string(14 - std::min<std::size_t>(13, limit.id.size()), ' ') +
            limit.description + "\n";
  }
  command->add_option("--only", options->only, "Tables to measure; all if absent")
      ->check(CLI::IsMember(names))
      ->type_name("NAME...");
  command
      ->add_option("--update", options->update,
                   "Markdown file whose tables are renewed, between <!-- limits:NAME --> and "
                   "<!-- limits:end -->")
      ->type_name("FILE");
  command->add_flag("--small", options->small, "Leave out grids of 256^3, which need 3 GB");
  command->footer("Tables:\n" + list);
  command->callback([options, &globals] { run_limits(*options, globals); });
}

}  // namespace kappamu::app
