// kappamu-studies: the measurements behind docs/benchmarks.md and its neighbours, one
// command per subject.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/program.h"
#include "pipeline/output_folder.h"
#include "studies/subject.h"

namespace kappamu::app {

namespace {

struct Options {
  studies::Request request;
  std::string out;
  std::vector<std::string> sections;
};

void run(Options options, const Globals& globals, const studies::Subject& subject) {
  const auto progress = make_progress();
  studies::Request& request = options.request;
  std::vector<std::filesystem::path> inputs;
  if (const auto data = request.settings.find("data"); data != request.settings.end()) {
    inputs.assign(data->second.begin(), data->second.end());
  }
  request.folder = pipeline::bench_folder(options.out, inputs);
  request.device = globals.device;
  request.seed = globals.seed;
  const auto records = studies::measure(subject, options.sections, request, *progress);
  if (globals.json) {
    print_json(studies::summary(subject, records, request.folder));
    return;
  }
  for (const studies::Json& record : records) {
    const auto section = record.at("section").get<std::string>();
    std::printf("%s%s\n\n", studies::printed(record).c_str(),
                studies::record_file(request.folder, subject, section).c_str());
  }
  std::printf("Charts and tables: studies/bench_charts.py %s\n", options.out.c_str());
}

void add_setting(CLI::App& command, const studies::Setting& setting, studies::Request& request) {
  const std::string name = setting.name;
  if (setting.kind == studies::Setting::Kind::flag) {
    command.add_flag_callback(
        "--" + name, [name, &request] { request.settings[name] = {}; }, setting.sentence);
    return;
  }
  auto* option = command.add_option_function<std::vector<std::string>>(
      "--" + name,
      [name, &request](const std::vector<std::string>& words) { request.settings[name] = words; },
      setting.sentence);
  if (setting.kind == studies::Setting::Kind::number) {
    option->expected(1)->type_name("NUMBER")->check(CLI::Range(setting.low, setting.high));
  } else {
    option->expected(1, -1)->type_name("WORD...");
    if (!setting.choices.empty()) option->check(CLI::IsMember(setting.choices));
  }
}

void add_subject(CLI::App& app, const studies::Subject& subject, Globals& globals) {
  auto* command = app.add_subcommand(subject.name, subject.sentence + ".\n\n" + subject.manual);
  auto options = std::make_shared<Options>();
  studies::Request& request = options->request;
  add_out(*command, options->out, "Folder for the records; made if missing");
  auto* small = command->add_flag_callback(
      "--small", [&request] { request.size = studies::Size::small; }, "Smaller problems: minutes");
  command
      ->add_flag_callback(
          "--quick", [&request] { request.size = studies::Size::quick; },
          "Toy problems, seconds: shows that it runs, proves nothing")
      ->excludes(small);
  for (const studies::Setting& setting : subject.settings) add_setting(*command, setting, request);
  if (subject.sections.size() > 1) {
    std::vector<std::string> names;
    std::string list = "Sections:\n";
    for (const studies::Section& section : subject.sections) {
      names.push_back(section.name);
      list += "  " + section.name;
      list.append(section.name.size() < 14 ? 14 - section.name.size() : 1, ' ');
      list += section.sentence + "\n";
    }
    command->add_option("--section", options->sections, "Measure these alone; all if absent")
        ->check(CLI::IsMember(names))
        ->type_name("NAME...");
    command->footer(list);
  }
  command->callback([options, &globals, &subject] { run(*options, globals, subject); });
}

void add_subjects(CLI::App& app, Globals& globals) {
  app.name("kappamu-studies");
  app.description(
      R"(Measure speed and accuracy: the numbers of docs/benchmarks.md and its neighbours.

Every section of a subject writes its raw numbers as one JSON record (machine, device,
build, repetitions) into the folder of -o; studies/bench_charts.py draws charts and tables
from them. studies/bench.sh measures all and renews the pages.)");
  for (const studies::Subject& subject : studies::subjects()) add_subject(app, subject, globals);
}

}  // namespace

}  // namespace kappamu::app

int main(int argc, char** argv) {
  return kappamu::app::run_program(argc, argv, kappamu::app::add_subjects);
}
