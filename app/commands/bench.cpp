// `kappamu bench`: the measurements that a user makes of their own machine. They are sections of
// kappamu-studies, the program beside this one that links what only measurements need.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "app/command.h"
#include "core/error.h"

namespace kappamu::app {

namespace {

struct Measurement {
  const char* name;
  const char* sentence;
  std::vector<std::string> words;  ///< subject and section of kappamu-studies
};

const std::vector<Measurement>& measurements() {
  static const std::vector<Measurement> all{
      {"solve",
       "Solves of a block by every method here, and by hypre where it is there",
       {"forward", "--section", "headline", "peers"}},
      {"samples",
       "Fits of the four samples of Wang et al. 2008; a quarter of an hour",
       {"inverse", "--section", "samples"}},
      {"objects", "Every model of objects beside Monte Carlo", {"objects", "--section", "models"}},
      {"sfdi",
       "Maps of phantoms and tissue that others photographed (--data), beside published values",
       {"sfdi", "--section", "phantoms", "tissue"}},
      {"fur", "Fur in shells beside the integral along rays", {"fur", "--section", "reference"}}};
  return all;
}

/// Becomes kappamu-studies with `words` and the options of every command before `bench`.
[[noreturn]] void become_studies(const CLI::App& app, std::vector<std::string> words) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("kappamu-studies");
  for (const char* option : {"--device", "--seed"}) {
    for (const std::string& value : app.get_option(option)->results())
      words.insert(words.end(), {option, value});
  }
  if (app.count("--json") > 0) words.emplace_back("--json");
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw InputError(program +
                   " cannot be started; measurements are a program of their own, which "
                   "scripts/build.sh release kappamu-studies builds");
}

}  // namespace

void add_bench(CLI::App& app, Globals&) {
  auto* command = app.add_subcommand(
      "bench",
      R"(Measure this machine: time against true error of solves, fits and models.

Each takes -o FOLDER for its record, --small or --quick for smaller problems. `kappamu doctor
--measure` measures what models of objects cost here. All other measurements of the documents are
those of the program kappamu-studies.)");
  command->require_subcommand(1);
  for (const Measurement& measurement : measurements()) {
    auto* one = command->add_subcommand(measurement.name, measurement.sentence);
    one->set_help_flag();
    one->fallthrough(false);
    one->prefix_command();
    one->callback([&app, one, &measurement] {
      std::vector<std::string> words = measurement.words;
      const std::vector<std::string> rest = one->remaining();
      words.insert(words.end(), rest.begin(), rest.end());
      become_studies(app, std::move(words));
    });
  }
}

}  // namespace kappamu::app
