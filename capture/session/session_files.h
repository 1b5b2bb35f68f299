// Which files a session names, and whether they lie in it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/session/session.h"

namespace kappamu::capture {

/// Whether files may lie behind symbolic links out of their folder.
enum class Links { within, anywhere };

/// All files that the session names, relative to its folder, in the order of session.json.
std::vector<std::string> named_files(const Session& session);

/// Whether folder/file lies in `folder` after symbolic links; a missing file, whether it would.
bool leads_inside(const std::filesystem::path& folder, const std::filesystem::path& file);

/// Throws InputError unless leads_inside().
void require_inside(const std::filesystem::path& folder, const std::filesystem::path& file);
/// The same for every file that the session names.
void require_files_inside(const Session& session);

}  // namespace kappamu::capture
