// One small simulated session, made once and shared by every test that needs frames.
#pragma once

#include <filesystem>

namespace kappamu {

/// Folder with session.json and its frames; simulated on the first call of any process, read-only.
const std::filesystem::path& tiny_session();

/// A copy in `folder` whose files are hard links: replace files there, never write into them.
std::filesystem::path linked_session(const std::filesystem::path& folder);

}  // namespace kappamu
