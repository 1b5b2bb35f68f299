#include "app/session_command.h"

#include <CLI/CLI.hpp>
#include <cmath>

#include "app/command.h"
#include "app/hdr_options.h"

namespace kappamu::app {

std::shared_ptr<SessionCommand> add_session_options(CLI::App& command) {
  auto options = std::make_shared<SessionCommand>();
  command.add_option("session", options->session, "Folder with session.json")
      ->required()
      ->type_name("SESSION");
  add_out(command, options->run, "Run folder; made if missing", "RUN");
  command.add_flag("--force", options->force, "Do it again even if it is up to date");
  add_follow_links(command, options->links);
  add_hdr_options(command, options->hdr);
  return options;
}

void add_follow_links(CLI::App& command, capture::Links& links) {
  command.add_flag_callback(
      "--follow-links", [&links] { links = capture::Links::anywhere; },
      "Read frames behind symbolic links that leave the session's folder; refused otherwise");
}

std::string time_taken(std::optional<double> seconds) {
  return seconds ? std::to_string(std::lround(*seconds)) + " s" : "up to date; --force to redo";
}

}  // namespace kappamu::app
