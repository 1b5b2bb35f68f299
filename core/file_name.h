// Names from files of others that become part of a path: what may be one, decided in one place.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace kappamu {

/// What is_plain_name() allows, to follow "use " in a sentence.
inline constexpr const char* plain_name_rule =
    "letters, digits, '_', '-' and '.', not starting with '.', at most 100 characters";

/// Whether a name (of a channel, pattern, station) can be part of a file's name on every system:
/// ASCII letters, digits, '_', '-' and '.', not starting with '.', 1 to 100 of them.
bool is_plain_name(std::string_view name);

/// Throws InputError "<where> is '<name>'; use ..." unless is_plain_name(name). `where` names file
/// and field.
void require_plain_name(std::string_view name, const std::string& where);

/// Whether a relative path stays in the folder it starts from as far as its text shows: not empty,
/// not absolute, no "..", no control characters. Symbolic links: capture::require_files_inside().
bool stays_inside(std::string_view relative_path);

/// ".png" of "A.PNG"; empty where there is none.
std::string lower_extension(const std::filesystem::path& file);

/// `text` for a message: control characters as \xNN.
std::string shown_name(std::string_view text);

}  // namespace kappamu
