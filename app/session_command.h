// What the commands that do one stage of a session's run share.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/command.h"
#include "capture/radiance/merge.h"
#include "capture/session/session_files.h"

namespace kappamu::app {

struct SessionCommand {
  std::string session;
  std::string run;
  bool force = false;
  capture::Links links = capture::Links::within;
  capture::MergeOptions hdr;
};

/// Adds SESSION, --out RUN, --force and the options between frames and radiance to `command`.
std::shared_ptr<SessionCommand> add_session_options(CLI::App& command);

/// Adds --follow-links to a command that reads a session's files.
void add_follow_links(CLI::App& command, capture::Links& links);

/// How long the stage took; none: there was nothing to do.
std::string time_taken(std::optional<double> seconds);

}  // namespace kappamu::app
