// Shared by capture's tests: a folder of its own, the documented example session.
#pragma once

#include <filesystem>
#include <string>

#include "io/read_file.h"
#include "tests/own_folder.h"

namespace kappamu::capture {

/// The JSON example of docs/formats.md, word for word.
std::string documented_session_text();

void write_text(const std::filesystem::path& file, const std::string& text);
using io::read_text;

}  // namespace kappamu::capture
