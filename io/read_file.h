// Whole files into memory, for the formats that are parsed there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace kappamu::io {

/// Throws InputError naming the file and the reason (missing, a folder, not readable).
std::vector<std::byte> read_bytes(const std::filesystem::path& file);
std::string read_text(const std::filesystem::path& file);

}  // namespace kappamu::io
