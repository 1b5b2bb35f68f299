// Whole files into memory, for the formats that are parsed there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace kappamu::io {

/// [bytes]; texts of ours have less than 1 MB, and what JSON makes of this one still fits in 1 GB.
constexpr std::size_t largest_text = std::size_t{8} << 20;

// Each throws InputError naming the file and the reason (missing, a folder, not readable, of more
// than `largest` bytes).
/// At its beginning, for formats that are read in parts.
std::ifstream open_file(const std::filesystem::path& file);
std::vector<std::byte> read_bytes(const std::filesystem::path& file,
                                  std::size_t largest = std::numeric_limits<std::size_t>::max());
std::string read_text(const std::filesystem::path& file, std::size_t largest = largest_text);

/// Hands over the file's bytes part by part. Those of a file of cache_bypass bytes and more do not
/// pass the system's cache.
void read_parts(const std::filesystem::path& file,
                const std::function<void(std::span<const char>)>& take);

}  // namespace kappamu::io
