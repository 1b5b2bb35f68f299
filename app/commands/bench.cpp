// `kappamu bench`: starts kappamu-bench, the program beside this one that links what only
// measurements need.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "app/command.h"
#include "core/error.h"

namespace kappamu::app {

namespace {

/// Becomes kappamu-bench with the words behind `bench` and the options of every command before it.
[[noreturn]] void become_bench(const CLI::App& app, std::vector<std::string> words) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("kappamu-bench");
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
                   " cannot be started; `kappamu bench` is a program of its own, which "
                   "scripts/build.sh release kappamu-bench builds");
}

}  // namespace

void add_bench(CLI::App& app, Globals&) {
  auto* command = app.add_subcommand(
      "bench", "Measure speed and accuracy: the numbers of docs/benchmarks.md and its neighbours.");
  command->set_help_flag();
  command->fallthrough(false);
  command->prefix_command();
  command->callback([&app, command] { become_bench(app, command->remaining()); });
}

}  // namespace kappamu::app
