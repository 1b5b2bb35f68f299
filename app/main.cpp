// The kappamu command: parses, dispatches, and turns failures into one sentence and an exit code.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <new>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

#include "app/command_list.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/json_reason.h"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

/// One sentence on standard error, whatever the names in it contain.
void report_failure(const std::exception& error) {
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  std::fprintf(stderr, "kappamu: %s\n",
               memory ? "out of memory; use a coarser grid or fewer patterns at once"
                      : kappamu::shown_text(kappamu::io::json_reason(error)).c_str());
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
      const std::string shown = kappamu::shown_name(part);
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
    std::fprintf(stderr, "%s\n", kappamu::shown_text(line).c_str());
  }
  return asked ? 0 : 2;
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

int main(int argc, char** argv) {
  using namespace kappamu;
  std::set_terminate(end_of_thread);
  for (const int crash : {SIGSEGV, SIGBUS, SIGABRT}) std::signal(crash, end_of_crash);
  // A file that outgrows the user's limit is a failed write with a sentence, not a silent death.
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app{
      "kappamu: from photographs of a translucent block to its diffusion and absorption "
      "coefficients"};
  app.name("kappamu");
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", "kappamu 0.1.0");
  app.footer(
      "kappamu COMMAND --help is the command's manual page.\n"
      "Exit codes: 0 done, 1 failed (one sentence), 2 usage, 3 not converged or not to be "
      "trusted.\n"
      "Start with: kappamu simulate --sample demo -o demo && kappamu run demo/session -o demo/run");
#ifdef __GLIBC__
  // Fields of tens of megabytes come and go with every solve: kept, their pages need not be mapped
  // and cleared anew, which takes a tenth of a large fit.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
  app::Globals globals;
  app.add_flag("--json", globals.json, "Make the last line on standard output one JSON object");
  app.add_option("--device", globals.device,
                 "auto (default), reference (no OpenCL), or part of a device name");
  app.add_option("--seed", globals.seed, "Seed wherever chance enters (default 1)");

  app::add_commands(app, globals);

  try {
    app.parse(argc, argv);
    return globals.exit_code;
  } catch (const CLI::ParseError& error) {
    return report_usage(app, error, {argv, static_cast<std::size_t>(argc)});
  } catch (const std::exception& error) {
    report_failure(error);
  }
  // Without destructors of what libraries keep for the whole program: an allocation that failed may
  // have left it half made.
  std::fflush(nullptr);
  std::_Exit(1);
}
