// What every subcommand shares. One file per subcommand, commands/<name>.cpp, which parses its
// options, calls the libraries and prints; it computes nothing itself.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/progress.h"

namespace CLI {
class App;
}

namespace kappamu::app {

/// Options every command understands, and what it leaves for main().
struct Globals {
  bool json = false;  ///< --json: the last line on standard output is one JSON object
  std::string device =
      "auto";              ///< --device: "auto", "reference", or part of an OpenCL device's name
  std::uint64_t seed = 1;  ///< --seed: wherever chance enters
  int exit_code = 0;  ///< 0 done, 3 finished without converging; failures throw (1), usage is 2
};

/// A program that calls commands instead of a terminal, as the Python package does.
class Caller {
 public:
  virtual ~Caller() = default;
  /// Who hears of the command's progress.
  virtual std::unique_ptr<Progress> progress() = 0;
  /// What --json prints.
  virtual void result(const nlohmann::ordered_json& object) = 0;
};

/// As long as it lives, the commands of this thread answer `caller`.
class CalledBy {
 public:
  explicit CalledBy(Caller& caller);
  ~CalledBy();
  CalledBy(const CalledBy&) = delete;
  CalledBy& operator=(const CalledBy&) = delete;
};

/// The caller's. Without one: a progress bar on standard error when that is a terminal, silent
/// otherwise; warnings always go to standard error.
std::unique_ptr<Progress> make_progress();

/// The line of --json, or the caller's result. What is not UTF-8, as in a stranger's file name, is
/// replaced.
void print_json(const nlohmann::ordered_json& object);

/// Adds --json, --device and --seed.
void add_globals(CLI::App& app, Globals& globals);

/// Check of an option's text: what is wrong with it, empty for a positive, finite number. CLI11's
/// own takes not-a-number for one.
std::string positive_number(const std::string& text);

/// Adds the required option -o of a file or folder to write.
void add_out(CLI::App& command, std::string& out, const std::string& text,
             const std::string& type = "OUT");

/// Adds --max-voxels of a command that reads volumes.
void add_most_voxels(CLI::App& command, std::size_t& most);

// Each adds its subcommand to `app`; `globals` outlives the parse.
void add_bench(CLI::App& app, Globals& globals);
void add_calibrate(CLI::App& app, Globals& globals);
void add_doctor(CLI::App& app, Globals& globals);
void add_edit(CLI::App& app, Globals& globals);
void add_export(CLI::App& app, Globals& globals);
void add_fit(CLI::App& app, Globals& globals);
void add_forward(CLI::App& app, Globals& globals);
void add_import(CLI::App& app, Globals& globals);
void add_map(CLI::App& app, Globals& globals);
void add_merge(CLI::App& app, Globals& globals);
void add_chart(CLI::App& app, Globals& globals);
void add_plan(CLI::App& app, Globals& globals);
void add_render(CLI::App& app, Globals& globals);
void add_view(CLI::App& app, Globals& globals);
void add_report(CLI::App& app, Globals& globals);
void add_run(CLI::App& app, Globals& globals);
void add_score(CLI::App& app, Globals& globals);
void add_simulate(CLI::App& app, Globals& globals);
void add_verify(CLI::App& app, Globals& globals);

}  // namespace kappamu::app
