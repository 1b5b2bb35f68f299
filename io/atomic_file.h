// Writing files so that a reader sees the old file or the new one, never a part: everything goes to
// a temporary name in the target's folder, is flushed to the disk, and is then renamed.
//
// Every function creates missing parent folders, removes its temporary on any failure, leaves an
// older file of the target's name untouched then, and throws InputError naming file and reason.
// Safe from several threads and processes at once; the last rename wins.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>

namespace kappamu::io {

/// Calls `write` with the temporary's name (it ends in the target's extension); `write` makes that
/// file or throws. InputError passes through; other exceptions become one InputError with their
/// text.
void write_atomically(const std::filesystem::path& target,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// Files of so many bytes and more should bypass the system's cache. There they cost memory and
/// time to copy, and most are dropped before they are read.
inline constexpr std::uintmax_t cache_bypass = std::uintmax_t{1} << 28;

/// Whether what is written stays in the system's cache for those who read it next, or goes to the
/// disk directly where the file system can.
enum class Cache { kept, bypassed };

/// Calls `write` with a seekable binary stream. A failed write is reported with the system's reason
/// even when `write` does not look at the stream's state.
void write_stream_atomically(const std::filesystem::path& target,
                             const std::function<void(std::ostream& out)>& write,
                             Cache cache = Cache::kept);

void write_bytes_atomically(const std::filesystem::path& target, std::span<const std::byte> bytes);
void write_text_atomically(const std::filesystem::path& target, std::string_view text);

/// Whether a file's name is one that this module gives to temporaries.
bool is_temporary_name(const std::string& name);

/// Removes the temporaries that a killed process left in `folder` and below, which must be a folder
/// of our own that no living process writes into. A missing folder is no error. Returns the number
/// removed.
std::size_t remove_temporaries(const std::filesystem::path& folder);

}  // namespace kappamu::io
