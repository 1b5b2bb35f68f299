// One small simulated session and its run, made once and shared by every test that needs them.
#pragma once

#include <filesystem>
#include <string>

#include "tests/app/process.h"

namespace kappamu {

/// Folder with session.json and its frames; simulated on the first call of any process, read-only.
const std::filesystem::path& tiny_session();

/// A copy in `folder` whose files are hard links: replace files there, never write into them.
std::filesystem::path linked_session(const std::filesystem::path& folder);

/// Folder that `kappamu run` filled from the session with the serial solver; read-only as well.
const std::filesystem::path& tiny_run();

/// The command that filled it, but for the folder, and what it printed and returned.
std::string tiny_run_arguments();
ProcessResult tiny_run_result();

/// A copy of it in `folder` that may be changed.
std::filesystem::path copied_run(const std::filesystem::path& folder);

}  // namespace kappamu
