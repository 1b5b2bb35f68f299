#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/bench_command.h"
#include "bench/choices.h"
#include "bench/record.h"
#include "io/atomic_file.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  std::string out;
  std::vector<std::string> subjects;
  bench::ChoicesOptions settings;
};

void run(const Options& options, const Globals& globals) {
  bench::ChoicesOptions settings = options.settings;
  settings.device = globals.device;
  settings.seed = globals.seed;
  const auto progress = make_progress();
  const std::filesystem::path out = pipeline::bench_folder(options.out);
  nlohmann::ordered_json last;
  for (const std::string& subject :
       options.subjects.empty() ? bench::choice_subjects() : options.subjects) {
    const auto scores = bench::measure_choices(subject, settings, *progress);
    last = bench::choices_record(subject, settings, scores);
    bench::write_record(last, out / ("choices-" + subject + ".json"));
    const std::string table = bench::choices_table(scores);
    bench::draw_choices(scores, out / ("bench-choices-" + subject + ".png"));
    io::write_text_atomically(out / ("table-choices-" + subject + ".md"), table);
    if (!globals.json) std::printf("%s\n%s\n", subject.c_str(), table.c_str());
  }
  if (globals.json) std::printf("%s\n", last.dump().c_str());
}

}  // namespace

void add_bench_choices(CLI::App& bench_command, Globals& globals) {
  auto* command = bench_command.add_subcommand(
      "choices",
      "What the fit's choices gain or cost under light it never saw (docs/theory.md, section "
      "4).\n\n"
      "  kappamu bench choices -o out/bench --subject loss\n\n"
      "SUBJECTS. held-out: 0, 1, 2, 4 of 16 patterns kept out. regulariser: h1, huber-tv at "
      "several edge slopes, the paper's "
      "at\n"
      "several weights ([W] figure 13). loss: gaussian, huber, student with and without 1 % of "
      "wild\n"
      "pixels.\n\n"
      "Blocks of 16x16x6 voxels, three truths (smooth fields of contrast 4, with two boxes, two\n"
      "layers), data from a grid twice as fine, judged as by `kappamu bench inverse`. Writes\n"
      "choices-<subject>.json, bench-choices-<subject>.png and table-choices-<subject>.md "
      "(medians\n"
      "over truths and seeds) into the folder of -o. A fit takes seconds: all subjects some ten "
      "minutes.");
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder for records and tables; made if missing")
      ->required()
      ->type_name("OUT");
  command->add_option("--subject", options->subjects, "Measure this alone; may be repeated")
      ->check(CLI::IsMember(bench::choice_subjects()))
      ->type_name("NAME");
  command
      ->add_option("--noise", options->settings.noise, "Relative noise (default 0.003 0.01 0.03)")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--truths", options->settings.truths, "The first so many of the three")
      ->check(CLI::Range(1, 3));
  command->add_option("--seeds", options->settings.seeds, "Noises per truth (default 1)")
      ->check(CLI::Range(1, 100));
  command->callback([options, &globals] { run(*options, globals); });
}

}  // namespace kappamu::app
