#include "app/program.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

#include "app/options/fit_options.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/process_memory.h"
#include "core/shown_text.h"
#include "device/kernel_cache.h"
#include "io/json_reason.h"

namespace kappamu::app {

namespace {

/// A line per command: the first paragraph of its manual page.
class OneLineEach : public CLI::Formatter {
 public:
  std::string make_subcommand(const CLI::App* command) const override {
    constexpr std::size_t name_width = 17;
    std::string text = command->get_description();
    text = text.substr(0, text.find("\n\n"));
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::string name = "  " + command->get_name();
    name.resize(std::max(name_width, name.size() + 1), ' ');
    return name + text + "\n";
  }
};

/// The options that are part of the fix, as the command line has them; empty: none.
std::string advised_options(const std::exception& error) {
  const auto* input = dynamic_cast<const InputError*>(&error);
  if (input == nullptr || input->options().empty()) return "";
  std::string list;
  for (const auto& [key, value] : input->options()) {
    list += (list.empty() ? " (" : ", ") + flag_of(key) + (value.empty() ? "" : " " + value);
  }
  return list + ")";
}

/// One sentence on standard error, whatever the names in it contain.
void report_failure(const std::exception& error) {
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  std::fprintf(stderr, "kappamu: %s%s\n",
               memory ? "out of memory; use a coarser grid or fewer patterns at once"
                      : shown_text(io::json_reason(error)).c_str(),
               advised_options(error).c_str());
}

/// All options at once that the command needs and was not given; empty: none.
std::string missing_options(const CLI::App& app) {
  std::string missing;
  for (const CLI::App* command : app.get_subcommands()) {
    for (const CLI::Option* option : command->get_options()) {
      if (!option->get_required() || option->count() > 0) continue;
      missing += (missing.empty() ? "" : ", ") + option->get_name(option->get_positional());
    }
  }
  return missing;
}

/// `text` with every argument in it that is long or cannot be shown as it is (an option's value by
/// itself, too) replaced by what can.
std::string with_shown_arguments(std::string text, std::span<char*> arguments) {
  for (const std::string_view argument : arguments) {
    for (const std::string_view part : {argument, argument.substr(argument.find('=') + 1)}) {
      const std::string shown = shown_name(part);
      if (shown == part) continue;
      for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += shown.size())
        text.replace(at, part.size(), shown);
    }
  }
  return text;
}

/// Help, or what is wrong with the arguments, which are shown as text of others is.
int report_usage(const CLI::App& app, const CLI::ParseError& error, std::span<char*> arguments) {
  const std::string missing = missing_options(app);
  if (error.get_name() == "RequiredError" && !missing.empty()) {
    std::fprintf(stderr, "required and missing: %s\nRun with --help for more information.\n",
                 missing.c_str());
    return 2;
  }
  std::ostringstream help, usage;
  const bool asked = app.exit(error, help, usage) == 0;
  std::printf("%s", help.str().c_str());
  std::istringstream lines(with_shown_arguments(usage.str(), arguments));
  for (std::string line; std::getline(lines, line);) {
    std::fprintf(stderr, "%s\n", shown_text(line).c_str());
  }
  return asked ? 0 : 2;
}

/// `code`, or 1 and a sentence where standard output did not take all that was printed: a script
/// would read an empty result of a command that succeeded.
int after_printing(int code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  std::fprintf(stderr,
               "kappamu: cannot write to standard output%s%s; what the command wrote into files is "
               "complete, free space or print elsewhere\n",
               errno == 0 ? "" : ": ", errno == 0 ? "" : std::strerror(errno));
  return 1;
}

/// An exception that a thread of ours or of a library could not pass on: the same sentence, and
/// nothing is cleaned up. What was written stays as after a kill.
[[noreturn]] void end_of_thread() {
  try {
    if (std::current_exception()) std::rethrow_exception(std::current_exception());
  } catch (const std::exception& error) {
    report_failure(error);
    std::_Exit(1);
  } catch (...) {
  }
  std::abort();
}

/// Libraries may crash where an allocation fails. Whatever was finished is whole, since files are
/// renamed when they are complete; which a warning reports.
extern "C" void end_of_crash(int) {
  constexpr char sentence[] =
      "kappamu: the program crashed, perhaps for want of memory; what it had not finished is left "
      "as "
      "after a kill, the same command does it again\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, sentence, sizeof sentence - 1);
  _exit(1);
}

}  // namespace

void add_globals(CLI::App& app, Globals& globals) {
  app.add_flag("--json", globals.json, "Make the last line on standard output one JSON object");
  app.add_option("--device", globals.device,
                 "auto (default), reference (no OpenCL), or part of a device name");
  app.add_option("--seed", globals.seed, "Seed wherever chance enters (default 1)");
}

void refuse_non_finite(CLI::App& app) {
  // What the types of options that hold floating-point numbers are called in the manual pages.
  static const std::set<std::string> numbers{"FLOAT", "FLOAT ...", "FACTOR", "G",
                                             "MM",    "SECONDS",   "SHARE",  "X,Y,Z",
                                             "F ...", "D ...",     "D"};
  for (CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();  // "FLOAT:FLOAT in [0 - 1]" with a range
    if (numbers.count(type.substr(0, type.find(':'))) == 0) continue;
    option->check([](const std::string& text) -> std::string {
      double value = 0.0;
      if (!CLI::detail::lexical_cast(text, value) || std::isfinite(value)) return {};
      return "'" + text + "' is not a finite number";
    });
  }
  for (CLI::App* command : app.get_subcommands({})) refuse_non_finite(*command);
}

int run_program(int argc, char** argv, void (*add)(CLI::App&, Globals&)) {
  std::set_terminate(end_of_thread);
  for (const int crash : {SIGSEGV, SIGBUS, SIGABRT}) std::signal(crash, end_of_crash);
  // A file that outgrows the user's limit is a failed write with a sentence, not a silent death.
  std::signal(SIGXFSZ, SIG_IGN);
  device::on_notice([](const std::string& sentence) {
    std::fprintf(stderr, "kappamu: %s\n", shown_text(sentence).c_str());
  });
  keep_freed_memory();
  CLI::App app;
  app.formatter(std::make_shared<OneLineEach>());
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", "kappamu 0.1.0");
  Globals globals;
  add_globals(app, globals);
  add(app, globals);
  refuse_non_finite(app);
  try {
    app.parse(argc, argv);
    return after_printing(globals.exit_code);
  } catch (const CLI::ParseError& error) {
    return after_printing(report_usage(app, error, {argv, static_cast<std::size_t>(argc)}));
  } catch (const std::exception& error) {
    report_failure(error);
  }
  // Without destructors of what libraries keep for the whole program: an allocation that failed may
  // have left it half made.
  std::fflush(nullptr);
  std::_Exit(1);
}

}  // namespace kappamu::app
